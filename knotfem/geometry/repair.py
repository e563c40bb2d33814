"""What is wrong with many files of points: points twice, exchanged or missing, and curves that are closed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.measures import turning_angles
from knotfem.geometry.polyline import Polyline
from knotfem.types import Array

TWIN = 1e-3
"""Distance between two successive points, over the median chord, below which they are one; no curve is drawn with
chords that differ a thousandfold."""

WIDE, GAP = 5.0, 20.0
"""Chords, over the median one, that are warned of and refused where the curve bends beside them. Chords of curves that
are drawn or measured differ by less than a factor of two; what a spline puts into a longer one was neither. Straight
ones are warned of, too, unless they belong to a lead."""

STRAIGHT = 0.3
"""A chord, however long, is a straight lead if the chords beside it turn from it by less [rad]."""

BACK = 2.6
"""A curve turns back where two chords turn by more [rad]: at 150 degrees, a rod of any thickness would be creased."""

MOST_NAMED = 5
"""Places that a message names."""

CLOSING = 2.0
"""A curve is closed if its ends are at most so many median chords apart and the chord between them goes on smoothly."""
SMOOTHLY = 0.5
"""Angle by which the closing chord may turn from those at the ends [rad]."""
ORDERS = (4, 10)
"""Of the differences that tell errors of points from the curve itself."""
FLAT = 0.85
"""Ratio of what they leave, above which it is errors: 0.95 to 1.15 for measured points, below 0.6 for drawn ones of
which a loop has more than ten."""

FEWEST_CLOSED = 8
"""Points of a curve that is taken for closed by the distance between its ends."""


def without_twins(curve: Polyline) -> tuple[Polyline, list[str]]:
    """A curve without points that stand twice, and a warning that names them."""
    kept, twins = [0], []
    smallest = TWIN * curve.median_chord
    if not (curve.chords <= smallest).any():
        return curve, []
    for row in range(1, len(curve)):
        if np.linalg.norm(curve.points[row] - curve.points[kept[-1]]) <= smallest:
            twins.append(curve.named(kept[-1], row))
        else:
            kept.append(row)
    said = f"{_listed(twins)} are the same; the second {'one is' if len(twins) == 1 else 'ones are'} left out"
    return curve.taken(np.array(kept)), [said]


def is_closed(curve: Polyline) -> bool:
    """Whether a curve is closed, be it that the file says so, that the first point stands at the end again, or that the
    ends are one chord apart, in the direction of the curve."""
    x, chord = curve.points, curve.median_chord
    gap = float(np.linalg.norm(x[-1] - x[0]))
    if curve.closed or gap <= TWIN * chord:
        return True
    if len(curve) < FEWEST_CLOSED or gap > CLOSING * chord:
        return False
    return bool(turning_angles(np.stack([x[-2], x[-1], x[0], x[1]])).max() < SMOOTHLY)


def opened(curve: Polyline, path: Path, number: int, apart: float) -> Polyline:
    """A closed curve, cut at one of its points: it begins there and ends somewhat before it.

    Args:
        curve: to be cut.
        path: of its file, for messages.
        number: of the point.
        apart: distance between the ends over the length of the closed curve.

    Raises:
        InputError: the curve is not closed, or has no such point.
    """
    if not is_closed(curve):
        problem = "only a closed curve is cut; the ends of this one are apart"
        raise InputError(problem, file=path, key="cut_at", found=number, expected="none")
    x = curve.points
    count = len(curve) - (np.linalg.norm(x[-1] - x[0]) <= TWIN * curve.median_chord)
    if number > count:
        raise InputError("no such point", file=path, key="cut_at", found=number, expected=f"1 to {count}")
    rows = np.roll(np.arange(count), 1 - number)
    ring = x[rows]
    length = float(np.linalg.norm(np.diff(ring, axis=0, append=ring[:1]), axis=1).sum())
    far = np.flatnonzero(np.linalg.norm(ring - ring[0], axis=1) >= apart * length)
    return curve.taken(rows[: (far[-1] + 1) if far.size else count], closed=False)


def check_order(curve: Polyline, path: Path, *, smoothed: bool) -> list[str]:
    """Refuse a curve that turns back, as exchanged points make it; warn of it where points will be smoothed.

    Raises:
        InputError: it turns back.
    """
    back = np.flatnonzero(turning_angles(curve.points) > BACK) + 1
    if not back.size:
        return []
    starts = back[np.diff(back, prepend=-2) > 1]
    places = [curve.named(row, min(row + 1, len(curve) - 1)) for row in starts]
    said = f"the curve turns back between {_listed(places)}"
    if smoothed:
        return [f"{said}, before it is smoothed"]
    expected = "points in their order along the curve (are two exchanged?), or smoothing of measured ones"
    raise InputError(said, file=path, expected=expected)


def check_gaps(curve: Polyline, path: Path) -> list[str]:
    """Refuse chords much longer than the others where the curve bends, warn of shorter ones and of all others but those
    of leads, which are straight and reach to an end of the curve.

    Raises:
        InputError: a gap.
    """
    chords, median = curve.chords, curve.median_chord
    usual = np.flatnonzero(chords <= WIDE * median)
    wide = [int(row) for row in np.flatnonzero(chords > WIDE * median)]
    bent = [row for row in wide if not _straight(curve.points, row)]
    worst = max(bent, key=lambda row: chords[row], default=None)
    if worst is not None and chords[worst] > GAP * median:
        expected = f"at most {GAP:g} times where the curve bends: are points missing?"
        found = f"{chords[worst]:.4g}"
        raise InputError(f"a gap: {_long_chord(curve, worst)}", file=path, found=found, expected=expected)
    gaps = [row for row in wide if row in bent or usual[0] < row < usual[-1]]
    if not gaps:
        return []
    more = f" (the longest of {len(gaps)} such gaps)" if len(gaps) > 1 else ""
    said = _long_chord(curve, max(gaps, key=lambda row: chords[row]))
    return [f"{said}; a spline bridges the gap{more}: are points missing?"]


def _long_chord(curve: Polyline, row: int) -> str:
    times = curve.chords[row] / curve.median_chord
    return f"the chord between {curve.named(row, row + 1)} is {times:.0f} times the median chord"


def _straight(x: Array, row: int) -> bool:
    """Whether the chord after a point goes on as those beside it do."""
    return bool(turning_angles(x[max(row - 1, 0) : row + 3]).max() < STRAIGHT)


def _listed(places: list[str]) -> str:
    more = len(places) - MOST_NAMED
    return ", ".join(places[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def scatter(points: Array) -> float:
    """Standard deviation of the errors of points along a smooth curve, for each coordinate, in their units.

    The differences of any order of independent errors are as large as their standard deviation times the root of the
    sum of squared binomial coefficients. Those of a curve become smaller, in this measure, with each order that its
    points resolve, so that what differences of tenth order leave is error if those of fourth order leave no more. The
    upper quartile of all places is taken: errors of rounding show at some points only.

    Args:
        points: shape (n, 3); 0 is returned for fewer than 16, and for points too coarse to tell.
    """
    if len(points) < ORDERS[1] + 6:
        return 0.0
    low, high = (_of_differences(points, order) for order in ORDERS)
    return high if high > FLAT * low else 0.0


def _of_differences(points: Array, order: int) -> float:
    """Standard deviation of independent errors that have the differences of so many points."""
    differences = np.linalg.norm(np.diff(points, order, axis=0), axis=1)
    return float(np.percentile(differences, 75.0)) / math.sqrt(3.0 * math.comb(2 * order, order))
