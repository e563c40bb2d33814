"""Where the rods of a scene lie when tied, whatever they are modelled by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry import validate
from knotfem.geometry.curve import Curve, interpolate
from knotfem.geometry.finite_rotation import rotate
from knotfem.geometry.grading import graded_slices
from knotfem.geometry.readers import read_centreline, unused_columns
from knotfem.geometry.resample import arc_parameters, chords, equal_chords
from knotfem.geometry.slices import Slices, equal_slices
from knotfem.geometry.smoothing import laplacian
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.scene.rods import MOST_SLICES, Rod
from knotfem.scene.steps import Driven, Pull
from knotfem.topology.knot_type import check_smoothing

CURVATURE_SPACING = 0.25
"""Distance of the points from which the curvature of a centreline is taken, in diameters."""
PUSHED = -0.5
"""Cosine between the outward tangent of an end and its pull, below which the pull pushes."""
SAFE_DIAMETERS = 2.0
"""Slices are as short as the tightest bend within so many diameters and the sliding of the rods wants them."""


@dataclass(frozen=True, eq=False)
class Centreline:
    """Where a rod is to lie when tied.

    Attributes:
        points: vertices [mm], whose chords are as long as the slices, shape [sections, 3].
        slices: of the rod.
        warnings: what deserves one.
    """

    points: np.ndarray
    slices: Slices
    warnings: tuple[str, ...] = ()


def centrelines_of(scene: Scene) -> list[Centreline]:
    """Centrelines of all rods, which must not overlap where there is contact; see `centreline_of`."""
    found = [centreline_of(rod, slices, scene) for rod, slices in zip(scene.rods, slices_of(scene), strict=True)]
    if scene.contact.enabled and len(found) > 1:
        lines, rods = [line.points for line in found], scene.rods
        warnings = validate.check_apart(lines, [rod.diameter for rod in rods], [rod.name for rod in rods])
        found[-1] = replace(found[-1], warnings=(*found[-1].warnings, *warnings))
    return found


def pushed_inwards(scene: Scene, centrelines: Sequence[Centreline]) -> list[str]:
    """A warning for each end that the first pull of a scene drives against the rod that it belongs to.

    Args:
        scene: of the rods.
        centrelines: of them.
    """
    pulls = ((i, step) for i, step in enumerate(scene.steps) if isinstance(step, Pull))
    number, pull = next(pulls, (0, None))
    lines = {rod.name: line.points for rod, line in zip(scene.rods, centrelines, strict=True)}
    warnings = []
    for (name, side), end in pull.all_ends().items() if pull is not None else ():
        if not isinstance(end, Driven):
            continue
        first, second = lines[name][[0, 1]] if side == "start" else lines[name][[-1, -2]]
        outwards, direction = first - second, np.asarray(end.direction)
        cosine = outwards @ direction / (np.linalg.norm(outwards) * np.linalg.norm(direction))
        if cosine < PUSHED:
            said = f"{np.degrees(np.arccos(max(cosine, -1.0))):.0f} degrees from the direction in which the rod ends"
            warnings.append(f"steps.{number}.ends.{name}.{side}: {said}; this pull pushes the end into the knot")
    return warnings


def slices_of(scene: Scene) -> list[Slices]:
    """Slices of all rods, of one length or as their centrelines turn.

    Raises:
        InputError: a centreline that has no chords as long as its slices, or too many slices.
    """
    return [_slices_of(rod, number, scene) for number, rod in enumerate(scene.rods)]


def _slices_of(rod: Rod, number: int, scene: Scene) -> Slices:
    if rod.mesh.turning_angle is None:
        return equal_slices(rod.length, rod.slices)
    curve, _ = _smoothed(rod)
    count = int(np.ceil(rod.length / (CURVATURE_SPACING * rod.diameter)))
    order = ORDERS[rod.mesh.element]
    angle, most = rod.mesh.turning_angle, rod.length / MOST_SLICES
    if angle * rod.radius < most:
        key, expected = f"rods.{number}.mesh.turning_angle", f"at least {most / rod.radius:.3g}"
        raise InputError("too many slices", key=key, found=f"{angle:g}", expected=expected)
    return graded_slices(
        curve(arc_parameters(curve, count + 1)),
        rod.length,
        rod.mesh.element_length / order,
        angle,
        SAFE_DIAMETERS * rod.diameter + scene.sliding,
        order,
    )


def _smoothed(rod: Rod) -> tuple[Curve, np.ndarray | None]:
    """A rod's centreline as a curve of its own scale, and vertices before smoothing where there is any [mm]."""
    curve = read_centreline(rod.curve_file)
    if rod.smoothing.iterations == 0:
        return curve, None
    raw = equal_chords(curve, rod.slices, rod.length).points
    return interpolate(laplacian(raw, rod.smoothing.gamma, rod.smoothing.iterations)), raw


def centreline_of(rod: Rod, slices: Slices, scene: Scene) -> Centreline:
    """Read, smooth, scale, resample, place and check a rod's centreline.

    Raises:
        InputError: no rod can lie along it.
    """
    curve, raw = _smoothed(rod)
    unsmoothed = None if raw is None else place(raw, rod)
    points = place(chords(curve, slices, rod.length).points, rod)
    obstacles = [
        validate.Cylinder((o.point[0], o.point[1], o.point[2]), (o.axis[0], o.axis[1], o.axis[2]), o.diameter)
        for o in scene.obstacles
        if scene.contact.enabled
    ]
    warnings = validate.check_centreline(
        points,
        rod.diameter,
        obstacles=obstacles,
        unsmoothed=unsmoothed,
        file=rod.centerline,
    )
    if unsmoothed is not None:
        check_smoothing(unsmoothed, points, rod.centerline)
    warnings += [
        f'{rod.centerline}: the column "{name}" is not used (the twist of a rod is rods.twist)'
        for name in unused_columns(rod.curve_file)
    ]
    return Centreline(points, slices, tuple(warnings))


def place(points: np.ndarray, rod: Rod) -> np.ndarray:
    """Turn and move a scaled curve to where the scene has it, shape [n, 3]."""
    return rotate(points, rod.rotation.axis, rod.rotation.angle) + np.array(rod.origin)
