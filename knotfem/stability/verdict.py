"""The verdict of a run: does the knot hold, slip or unravel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "slips", "unravels", "undecided"]

SLIP_OVER_DIAMETER = 1.0
"""A rod that runs through its knot by more slips, unless it comes to rest."""
SLIP_RATE, HOLD_RATE = 0.9, 0.1
"""In a pull the knot slips where at least the one fraction of the last displacement runs through it, and holds where at
most the other one does; between them it tightens."""
RATE_OVER_DIAMETER = 2.0
"""The last displacement: so much of a pull."""


@dataclass(frozen=True)
class Signs:
    """What tells whether a knot holds.

    Attributes:
        lost: what has come undone, in words; "" where the knot is what it was.
        at_rest: whether the rods came to rest under loads that stood still.
        through: length of rod that ran through the knot since the step began [mm].
        rate: fraction of the last displacement of a driven end that ran through the knot; nan where none is driven, or
            where it has not been driven so far.
        diameter: of the thinnest rod [mm].
        drawn_in: length by which a free end was drawn in when that ended the step [mm]; nan where it did not.
    """

    lost: str
    at_rest: bool
    through: float
    rate: float
    diameter: float
    drawn_in: float = math.nan


def verdict_of(signs: Signs) -> Verdict:
    """The verdict.

    - *unravels*: the knot is no longer what it was.
    - *holds*: it is what it was, and came to rest under the load; in a pull, the last displacement did not run through.
    - *slips*: it is what it was, but the rod runs through it, or a free end was drawn in as far as the step allows.
    - *undecided*: none of these showed before the run ended; so ends a pull that tightens the knot.
    """
    if signs.lost:
        return "unravels"
    if signs.at_rest:
        return "holds"
    if not math.isnan(signs.drawn_in):
        return "slips"
    if not math.isnan(signs.rate):
        return "slips" if signs.rate >= SLIP_RATE else "holds" if signs.rate <= HOLD_RATE else "undecided"
    return "slips" if signs.through > SLIP_OVER_DIAMETER * signs.diameter else "undecided"


def in_words(verdict: Verdict, signs: Signs, mode: str) -> str:
    """The verdict as a sentence."""
    d = f"{signs.through / signs.diameter:.1f} diameters"
    if verdict == "unravels":
        slid = {"wrapping": "; the wrapping strand slipped first", "central": "; the central strands slipped first"}
        return f"the knot unravels: {signs.lost}{slid.get(mode, '')}"
    if verdict == "holds" and signs.at_rest:
        return f"the knot holds: it came to rest under the load after {d} of rod had run through it"
    if not math.isnan(signs.drawn_in):
        return f"the knot slips: a free end was drawn in by {signs.drawn_in:.3g} mm"
    if not math.isnan(signs.rate):
        last = f"{100.0 * signs.rate:.0f} % of the last displacement ran through it"
        said = {"holds": "the knot holds", "slips": "the knot slips"}.get(verdict, "undecided, the knot still tightens")
        return f"{said}: {last}"
    if verdict == "slips":
        return f"the knot slips: {d} of rod ran through it, and it did not come to rest"
    return f"undecided: the run ended before the knot came to rest or slipped, after {d} of rod had run through it"
