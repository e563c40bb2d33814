"""Checks that a rod of given diameter can take the shape of a centreline."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.clearance import (
    NEIGHBOUR_RADII,
    Clearance,
    cylinder_clearance,
    rod_clearance,
    strand_clearance,
)
from knotfem.geometry.measures import arclength, curvature, turning_angles
from knotfem.geometry.points import FEWEST_POINTS, as_points
from knotfem.types import Array

LARGEST_CURVATURE = 1.6
"""Largest product of curvature and diameter. At 2 the innermost fibre of the bend is shortened to nothing, at 1.6 to a
fifth of its length; knots with 1.18 have been tied."""

LARGEST_TURN = 0.85
"""Largest angle between successive edges [rad]. An edge is then 3 % shorter than the arc it stands for, and the mapping
begins to fail."""

CLOSE = 1.05
"""Distance between strands after smoothing, in diameters, below which a warning is given."""

TOUCHING = 1e-6
"""Largest overlap, in diameters, that still counts as touching."""

DEEPEST = 0.9
"""Smallest distance between the centrelines of two strands in the initial configuration, in mean diameters. Contact
separates them before a scene's first step has come to rest; the tight knots that the program itself computes and those
that are measured overlap by a few percent."""

SCATTERED = 0.007
"""Scatter of points, in diameters, above which they count as measured: whether strands overlap by a few percent is not
known then."""


class Cylinder(NamedTuple):
    """A rigid cylinder of infinite length.

    Attributes:
        point: any point of its axis, mm.
        axis: its direction, of any length.
        diameter: mm.
    """

    point: tuple[float, float, float]
    axis: tuple[float, float, float]
    diameter: float


def check_centreline(
    points: ArrayLike,
    diameter: float,
    *,
    obstacles: Sequence[Cylinder] = (),
    unsmoothed: ArrayLike | None = None,
    scatter: float = 0.0,
    file: str | Path | None = None,
) -> list[str]:
    """Refuse a centreline that no rod of this diameter can take; return warnings for doubtful ones.

    Args:
        points: vertices after smoothing, scaling and resampling, several per diameter, shape (n, 3), mm.
        diameter: of the rod, mm.
        obstacles: that the rod must not overlap.
        unsmoothed: vertices before smoothing, scaled to the same length, shape (m, 3), mm. Overlaps are judged after
            smoothing. Whether the smoothing has changed the knot is checked by
            `knotfem.topology.closures.check_smoothing`.
        scatter: of the points that the curve was made of, mm; see `knotfem.geometry.repair.scatter`.
        file: named in the messages.

    Returns:
        Warnings, usually none.

    Raises:
        InputError: points that are not finite, too few or repeated; a closed curve; curvature x diameter above 1.6; an
            angle above 0.85 rad between successive edges; a rod of this diameter that crosses itself, or overlaps
            itself by more than a tenth of the diameter, or at all where its points scatter and are not smoothed; an
            overlap with an obstacle.
    """
    if not (np.isfinite(diameter) and diameter > 0.0):
        raise InputError("rod diameter is not positive", file=file, found=diameter, expected="above 0 mm")
    x = as_points(points, fewest=FEWEST_POINTS, file=file)
    _check_open(x, diameter, file)
    drawn = None if unsmoothed is None else as_points(unsmoothed, fewest=FEWEST_POINTS, file=file)
    measured = drawn is None and scatter > SCATTERED * diameter
    warnings = _check_strands(x, diameter, drawn, scatter if measured else 0.0, file)
    _check_curvature(x, diameter, file)
    _check_turns(x, file)
    for number, obstacle in enumerate(obstacles, start=1):
        _check_obstacle(x, diameter, obstacle, number, file)
    return warnings if warnings or drawn is None else _smoothing_warnings(drawn, x, diameter)


def check_apart(
    lines: Sequence[Array], diameters: Sequence[float], names: Sequence[str], *, cure: str = ""
) -> list[str]:
    """Refuse rods that overlap each other by more than a tenth of their mean diameter; warn of smaller overlaps.

    Args:
        lines: centrelines, each of shape (n, 3), mm.
        diameters: of the rods, mm.
        names: of the rods, for the messages.
        cure: what else may be wrong, for the message of an error.

    Returns:
        Warnings, one for each pair of rods that overlap.

    Raises:
        InputError: two rods overlap by more than a tenth of their mean diameter.
    """
    warnings = []
    for i, j in combinations(range(len(lines)), 2):
        touching = 0.5 * (diameters[i] + diameters[j])
        closest = rod_clearance(lines[i], lines[j])
        if closest.distance >= (1.0 - TOUCHING) * touching:
            continue
        ends = (lines[i], closest.i, names[i]), (lines[j], closest.j, names[j])
        places = " and ".join(f"s/L = {_fraction(line, edge)} of {name}" for line, edge, name in ends)
        if closest.distance < DEEPEST * touching:
            problem = f"the rod overlaps {names[i]}: {places} (distance of centrelines)"
            expected = f"at least {touching:.4g} mm ({DEEPEST * touching:.4g} mm for rods pressed together){cure}"
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
        problem = f"the curve bends too sharply to be meshed at s/L = {_fraction(x, i)} (curvature x diameter)"
        raise InputError(problem, file=file, found=f"{sharpness[i]:.3g}", expected=f"at most {LARGEST_CURVATURE}")


def _check_turns(x: Array, file: str | Path | None) -> None:
    turns = turning_angles(x)
    i = int(np.argmax(turns)) + 1
    if turns[i - 1] > LARGEST_TURN:
        problem = f"edges are too long to follow the curve at s/L = {_fraction(x, i)} (angle between two of them)"
        expected = f"at most {LARGEST_TURN} rad; take shorter elements or smooth the curve"
        raise InputError(problem, file=file, found=f"{turns[i - 1]:.3g} rad", expected=expected)


def _check_strands(
    x: Array, diameter: float, drawn: Array | None, scatter: float, file: str | Path | None
) -> list[str]:
    """Refuse a rod that overlaps itself too deeply; warn of a smaller overlap, which contact removes.

    Args:
        x: vertices, shape (n, 3), mm.
        diameter: of the rod, mm.
        drawn: vertices before smoothing, shape (m, 3), mm; None without.
        scatter: of points that are measured and not smoothed, mm; 0 for others.
        file: named in the message.
    """
    closest = strand_clearance(x, diameter)
    if closest.distance >= (1.0 - TOUCHING) * diameter:
        return []
    places = f"s/L = {_places(x, closest)}"
    if closest.distance >= DEEPEST * diameter and scatter == 0.0:
        before = "" if drawn is None else _before(drawn, diameter)
        depth = diameter - closest.distance
        overlap = f"{depth:.3g} mm ({100.0 * depth / diameter:.1f} % of the diameter)"
        name = "" if file is None else f"{file}: "
        return [f"{name}strands overlap by {overlap} at {places}{before}; contact separates them"]
    crossing = closest.distance < 0.01 * diameter
    problem = f"the rod {'crosses' if crossing else 'overlaps'} itself at {places} (distance of strands)"
    expected = f"at least the diameter, {diameter:.4g} mm ({DEEPEST * diameter:.4g} mm for strands pressed together)"
    if drawn is not None:
        problem += f" after smoothing{_before(drawn, diameter)}"
        closer = strand_clearance(drawn, diameter).distance > closest.distance
        expected += f"; {'fewer iterations, or smoothing.keep_size = true' if closer else 'more iterations'}"
    elif scatter > 0.0:
        problem += f"; the points scatter by about {scatter:.2g} mm"
        expected += "; smooth measured points (smoothing.iterations = 1000)"
    raise InputError(problem, file=file, found=f"{closest.distance:.4g} mm", expected=expected)


def _before(drawn: Array, diameter: float) -> str:
    return f"; {strand_clearance(drawn, diameter).distance / diameter:.2f} diameters apart before smoothing"


def _places(x: Array, closest: Clearance) -> str:
    return f"{_fraction(x, closest.i)} and {_fraction(x, closest.j)}"


def _fraction(x: Array, i: int) -> str:
    """Arclength at a vertex as a fraction of the length, for a message."""
    arc = arclength(x)
    return f"{arc[i] / arc[-1]:.3f}"


def _check_obstacle(x: Array, diameter: float, obstacle: Cylinder, number: int, file: str | Path | None) -> None:
    gap = cylinder_clearance(x, obstacle.point, obstacle.axis, obstacle.diameter, diameter)
    if gap < -TOUCHING * diameter:
        inside = "runs inside" if gap < -0.5 * diameter else "overlaps"
        problem = f"the rod {inside} obstacle {number} (gap between their surfaces)"
        raise InputError(problem, file=file, found=f"{gap:.4g} mm", expected="0 mm or more")


def _smoothing_warnings(drawn: Array, x: Array, diameter: float) -> list[str]:
    before, after = strand_clearance(drawn, diameter), strand_clearance(x, diameter)
    if after.distance >= CLOSE * diameter or after.distance >= before.distance:
        return []
    apart = f"from {before.distance / diameter:.2f} to {after.distance / diameter:.2f} diameters apart"
    return [f"smoothing has brought strands {apart} at s/L = {_places(x, after)}"]
