"""What a centreline must be before a rod can be tied along it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.measures import (
    NEIGHBOUR_RADII,
    Clearance,
    arclength,
    curvature,
    cylinder_clearance,
    rod_clearance,
    strand_clearance,
    turning_angles,
)
from knotfem.geometry.points import FEWEST_POINTS, Array, as_points
from knotfem.topology.knot_type import knot_type

LARGEST_CURVATURE = 1.6
"""Curvature x diameter. At 2 the inner fibre has no length left, 1.18 has been tied; 1.6 leaves it a fifth."""

LARGEST_TURN = 0.85
"""Angle between neighbouring edges [rad]: there an edge is 3 % shorter than its arc, and the mapping begins to fail."""

CLOSE = 1.05
"""Strands closer than this, in diameters, after smoothing are worth a warning."""

TOUCHING = 1e-6
"""Overlap, in diameters, that still counts as touching."""

DEEPEST = 0.9
"""Distance of two rods' centrelines, in diameters, down to which they may begin pressed together."""


class Cylinder(NamedTuple):
    """An endless rigid cylinder.

    Attributes:
        point: on its axis, mm.
        axis: direction.
        diameter: mm.
    """

    point: tuple[float, float, float]
    axis: tuple[float, float, float]
    diameter: float


def check_centerline(
    points: ArrayLike,
    diameter: float,
    *,
    obstacles: Sequence[Cylinder] = (),
    unsmoothed: ArrayLike | None = None,
    file: str | Path | None = None,
) -> list[str]:
    """Refuse a centreline along which no rod can lie; return what deserves a warning.

    Args:
        points: vertices after smoothing, scaling and resampling, several a diameter, shape (n, 3), mm.
        diameter: of the rod, mm.
        obstacles: that the rod must not overlap.
        unsmoothed: vertices before smoothing, scaled to the same length, shape (m, 3), mm. Given, an overlap that only
            the smoothing has made is a warning; an overlap in the curve as drawn stays an error.
        file: named in the messages.

    Returns:
        Warnings, usually none.

    Raises:
        InputError: not finite, too few or repeated points; closed; bent more sharply than curvature x diameter = 1.6;
            turning by more than 0.85 rad from edge to edge; crossing itself or overlapping at the rod's diameter; a
            knot changed by the smoothing; inside an obstacle.
    """
    if not (np.isfinite(diameter) and diameter > 0.0):
        raise InputError("rod diameter is not positive", file=file, found=diameter, expected="above 0 mm")
    x = as_points(points, fewest=FEWEST_POINTS, file=file)
    _check_open(x, diameter, file)
    drawn = x if unsmoothed is None else as_points(unsmoothed, fewest=FEWEST_POINTS, file=file)
    _check_strands(drawn, diameter, file)
    _check_curvature(x, diameter, file)
    _check_turns(x, file)
    for number, obstacle in enumerate(obstacles, start=1):
        _check_obstacle(x, diameter, obstacle, number, file)
    return [] if unsmoothed is None else _smoothing_warnings(drawn, x, diameter, file)


def check_apart(lines: Sequence[Array], diameters: Sequence[float], names: Sequence[str]) -> list[str]:
    """Refuse rods that overlap each other by more than a tenth of their mean diameter; a warning for less.

    Args:
        lines: centrelines, shapes (n, 3), mm.
        diameters: of the rods, mm.
        names: of the rods, for the messages.

    Raises:
        InputError: two rods overlap by more.
    """
    warnings = []
    for i, j in combinations(range(len(lines)), 2):
        touching = 0.5 * (diameters[i] + diameters[j])
        closest = rod_clearance(lines[i], lines[j])
        if closest.distance >= (1.0 - TOUCHING) * touching:
            continue
        ends = (lines[i], closest.i, names[i]), (lines[j], closest.j, names[j])
        places = " and ".join(f"s/L = {_share(line, edge)} of {name}" for line, edge, name in ends)
        if closest.distance < DEEPEST * touching:
            problem = f"the rod overlaps {names[i]}: {places} (distance of centrelines)"
            expected = f"at least {touching:.4g} mm ({DEEPEST * touching:.4g} mm where they begin pressed together)"
            raise InputError(problem, key=f"rods.{j}", found=f"{closest.distance:.4g} mm", expected=expected)
        warnings.append(f"{names[j]} and {names[i]} overlap by {touching - closest.distance:.3g} mm: {places}")
    return warnings


def _check_open(x: Array, diameter: float, file: str | Path | None) -> None:
    gap = float(np.linalg.norm(x[-1] - x[0]))
    if gap < diameter and arclength(x)[-1] > 0.5 * NEIGHBOUR_RADII * diameter:
        problem = "the curve is closed: its ends are less than a rod diameter apart"
        raise InputError(problem, file=file, found=f"{gap:.4g} mm", expected=f"at least {diameter:.4g} mm")


def _check_curvature(x: Array, diameter: float, file: str | Path | None) -> None:
    sharpness = curvature(x) * diameter
    i = int(np.argmax(sharpness))
    if sharpness[i] > LARGEST_CURVATURE:
        problem = f"the curve bends too sharply to be meshed at s/L = {_share(x, i)} (curvature x diameter)"
        raise InputError(problem, file=file, found=f"{sharpness[i]:.3g}", expected=f"at most {LARGEST_CURVATURE}")


def _check_turns(x: Array, file: str | Path | None) -> None:
    turns = turning_angles(x)
    i = int(np.argmax(turns)) + 1
    if turns[i - 1] > LARGEST_TURN:
        problem = f"edges are too long to follow the curve at s/L = {_share(x, i)} (angle between two of them)"
        expected = f"at most {LARGEST_TURN} rad; take shorter elements or smooth the curve"
        raise InputError(problem, file=file, found=f"{turns[i - 1]:.3g} rad", expected=expected)


def _check_strands(x: Array, diameter: float, file: str | Path | None) -> None:
    closest = strand_clearance(x, diameter)
    if closest.distance >= (1.0 - TOUCHING) * diameter:
        return
    crossing = closest.distance < 0.01 * diameter
    problem = (
        f"the rod {'crosses' if crossing else 'overlaps'} itself at s/L = {_places(x, closest)} (distance of strands)"
    )
    expected = f"at least the diameter, {diameter:.4g} mm"
    raise InputError(problem, file=file, found=f"{closest.distance:.4g} mm", expected=expected)


def _places(x: Array, closest: Clearance) -> str:
    return f"{_share(x, closest.i)} and {_share(x, closest.j)}"


def _share(x: Array, i: int) -> str:
    """Share of the arclength at a vertex."""
    arc = arclength(x)
    return f"{arc[i] / arc[-1]:.3f}"


def _check_obstacle(x: Array, diameter: float, obstacle: Cylinder, number: int, file: str | Path | None) -> None:
    gap = cylinder_clearance(x, obstacle.point, obstacle.axis, obstacle.diameter, diameter)
    if gap < -TOUCHING * diameter:
        inside = "runs inside" if gap < -0.5 * diameter else "overlaps"
        problem = f"the rod {inside} obstacle {number} (gap between their surfaces)"
        raise InputError(problem, file=file, found=f"{gap:.4g} mm", expected="0 mm or more")


def _smoothing_warnings(drawn: Array, x: Array, diameter: float, file: str | Path | None) -> list[str]:
    was, now = knot_type(drawn), knot_type(x)
    if was.jones != now.jones:
        raise InputError(
            "smoothing has changed the knot; take fewer iterations", file=file, found=now, expected=str(was)
        )
    before, after = strand_clearance(drawn, diameter), strand_clearance(x, diameter)
    if after.distance >= CLOSE * diameter or after.distance >= before.distance:
        return []
    was_apart, now_apart = before.distance / diameter, after.distance / diameter
    return [
        f"smoothing has brought strands from {was_apart:.2f} to {now_apart:.2f} diameters apart "
        f"at s/L = {_places(x, after)}{'; they overlap' if now_apart < 1.0 else ''}"
    ]
