"""Combinations of rungs that promise an accuracy at the least cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from knotfem.study.ladders import BASE, Rung


@dataclass(frozen=True)
class Option:
    """One rung of a ladder as a part of a combination.

    Attributes:
        rung: what it sets.
        error: its own one, with the uncertainty of the limit that it is taken against.
        cost: CPU seconds over those of the base.
    """

    rung: Rung
    error: float
    cost: float


def combine(families: Sequence[Mapping[str, Sequence[Option]]], target: float) -> Rung | None:
    """The combination of one rung of each ladder that is expected to be cheapest within an error.

    Errors of separate choices are taken to add up and their costs to multiply.

    Args:
        families: ladders whose errors add up, each with its rungs, the base among them.
        target: largest sum of errors.

    Returns:
        None where no combination is that accurate, or where the best one is a rung already.
    """
    best, least = None, float("inf")
    for parts in (parts for options in families for parts in product(*options.values())):
        cost = 1.0
        for part in parts:
            cost *= part.cost
        if cost < least and sum(part.error for part in parts) <= target:
            best, least = parts, cost
    changed = [part.rung for part in best or () if part.rung.name != BASE]
    if len(changed) < 2:
        return None
    return Rung(
        "+".join(rung.name for rung in changed),
        "chosen",
        f"for {target:.3g}: " + ", ".join(f"{rung.ladder} {rung.setting}" for rung in changed),
        None,
        tuple(override for rung in changed for override in rung.overrides),
    )
