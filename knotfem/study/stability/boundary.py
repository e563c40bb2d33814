"""The friction from which on a knot holds, between the points that have a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

DIGITS = 6
"""Decimal places of a friction that is tried."""


@dataclass(frozen=True)
class Bracket:
    """Between which frictions a knot begins to hold.

    Attributes:
        low: largest friction below `high` at which it does not hold.
        high: smallest friction above all at which it does not hold.
        monotone: whether it holds at no friction below `low`.
    """

    low: float
    high: float
    monotone: bool

    @property
    def middle(self) -> float:
        """The threshold, to half the width."""
        return 0.5 * (self.low + self.high)


def bracket_of(known: Mapping[float, bool]) -> Bracket | None:
    """The bracket that verdicts give.

    Args:
        known: whether the knot holds, by friction.

    Returns:
        None where it holds at none of them, or at all.
    """
    failing = [friction for friction, holds in known.items() if not holds]
    if not failing:
        return None
    low = max(failing)
    holding = [friction for friction, holds in known.items() if holds]
    above = [friction for friction in holding if friction > low]
    return Bracket(low, min(above), len(above) == len(holding)) if above else None


def next_friction(
    known: Mapping[float, bool], tried: frozenset[float], limits: tuple[float, float], width: float
) -> float | None:
    """The friction to try next, or None where the bracket is as narrow as wanted or cannot be narrowed.

    Halves lie at multiples of the width from the lower end, so that brackets of one width are comparable.

    Args:
        known: whether the knot holds, by friction.
        tried: frictions that are under way or have no verdict.
        limits: smallest and largest friction to try.
        width: of the bracket that is wanted.
    """
    lowest, highest = limits
    found = bracket_of(known)
    if found is not None:
        steps = round((found.high - found.low) / width, 6)
        if steps <= 1.0:
            return None
        wanted = round(found.low + width * max(1, int(steps / 2.0)), DIGITS)
    else:
        wanted = lowest if known and all(known.values()) else highest
    return None if wanted in known or wanted in tried else wanted
