"""Combinations of levels that promise an accuracy at the least cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from knotfem.study.refinement import BASE, Level


@dataclass(frozen=True)
class Option:
    """One level of a series as a part of a combination.

    Attributes:
        level: what it sets.
        error: its own one, with the uncertainty of the limit that it is taken against.
        cost: CPU seconds over those of the base.
    """

    level: Level
    error: float
    cost: float


def combine(families: Sequence[Mapping[str, Sequence[Option]]], target: float) -> Level | None:
    """The combination of one level of each series that is expected to be cheapest within an error.

    Errors of separate choices are taken to add up and their costs to multiply.

    Args:
        families: series whose errors add up, each with its levels, the base among them.
        target: largest sum of errors.

    Returns:
        None where no combination is that accurate, or where the best one is a level already.
    """
    every = (parts for options in families for parts in product(*options.values()))
    good = (parts for parts in every if sum(part.error for part in parts) <= target)
    best = min(good, key=lambda parts: prod(part.cost for part in parts), default=())
    changed = [part.level for part in best if part.level.name != BASE]
    if len(changed) < 2:
        return None
    return Level(
        "+".join(level.name for level in changed),
        "chosen",
        f"for {target:.3g}: " + ", ".join(f"{level.series} {level.setting}" for level in changed),
        None,
        tuple(override for level in changed for override in level.overrides),
    )
