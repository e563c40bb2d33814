"""Where the rods of a scene lie when tied, whatever they are modelled by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry import validate
from knotfem.geometry.finite_rotation import rotate
from knotfem.geometry.grading import graded_slices
from knotfem.geometry.resample import arc_parameters, chords
from knotfem.geometry.slices import Slices, equal_slices
from knotfem.models.curve_size import ONE_FRAME, Size, scaling_warnings
from knotfem.models.drawn import Drawn, drawn_curves
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.scene.rods import MOST_SLICES, Rod
from knotfem.scene.steps import Driven, Pull
from knotfem.topology.closures import check_smoothing

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
        size: in which the curve is taken.
        warnings: what deserves one.
    """

    points: np.ndarray
    slices: Slices
    size: Size
    warnings: tuple[str, ...] = ()


def centrelines_of(scene: Scene) -> list[Centreline]:
    """Read, smooth, scale, resample, place and check the centrelines of all rods; no rod may overlap another.

    Raises:
        InputError: no rods can lie along them.
    """
    drawn = drawn_curves(scene)
    laid = [
        _laid(rod, curve, slices)
        for rod, curve, slices in zip(scene.rods, drawn, _slices_along(scene, drawn), strict=True)
    ]
    found = [_checked(rod, curve, one, scene) for rod, curve, one in zip(scene.rods, drawn, laid, strict=True)]
    said = scaling_warnings(scene.rods, drawn, [line.size for line in found])
    if scene.contact.enabled and len(found) > 1:
        lines, rods = [line.points for line in found], scene.rods
        cure = "; do they have one scale?" if any(ONE_FRAME in text for texts in said for text in texts) else ""
        diameters, names = [rod.diameter for rod in rods], [rod.name for rod in rods]
        said[-1] += validate.check_apart(lines, diameters, names, cure=cure)
    return [replace(line, warnings=(*line.warnings, *more)) for line, more in zip(found, said, strict=True)]


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
    graded = any(rod.mesh.turning_angle is not None for rod in scene.rods)
    return _slices_along(scene, drawn_curves(scene) if graded else [])


def _slices_along(scene: Scene, drawn: Sequence[Drawn]) -> list[Slices]:
    """Slices of all rods along their curves, which rods of equal slices do not need."""
    return [
        equal_slices(rod.length, rod.slices)
        if rod.mesh.turning_angle is None
        else _graded(rod, rod.mesh.turning_angle, number, drawn[number], scene)
        for number, rod in enumerate(scene.rods)
    ]


def _graded(rod: Rod, angle: float, number: int, drawn: Drawn, scene: Scene) -> Slices:
    curve, _ = drawn.along(equal_slices(rod.length, rod.slices), rod.centerline)
    count = int(np.ceil(rod.length / (CURVATURE_SPACING * rod.diameter)))
    order = ORDERS[rod.mesh.element]
    most = rod.length / MOST_SLICES
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


@dataclass(frozen=True, eq=False)
class _Laid:
    """A rod's vertices, not yet placed.

    Attributes:
        points: [mm], shape [sections, 3].
        slices: of the rod.
        factor: mm per unit of the file.
        added: by which the ends were made longer [mm].
    """

    points: np.ndarray
    slices: Slices
    factor: float
    added: float


def _laid(rod: Rod, drawn: Drawn, slices: Slices) -> _Laid:
    curve, added = drawn.along(slices, rod.centerline)
    found = chords(curve, slices, rod.length, file=rod.centerline)
    scaled = found.scale if drawn.unsmoothed is None else found.scale * drawn.read
    return _Laid(found.points, slices, drawn.read if drawn.factor is not None else scaled, added)


def _checked(rod: Rod, drawn: Drawn, laid: _Laid, scene: Scene) -> Centreline:
    """A rod's centreline in its place, after checks.

    Raises:
        InputError: no rod can lie along it.
    """
    unsmoothed = None if drawn.unsmoothed is None else place(drawn.unsmoothed, rod)
    points = place(laid.points, rod)
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
        scatter=drawn.scatter,
        file=rod.centerline,
    )
    if unsmoothed is not None:
        check_smoothing(unsmoothed, points, rod.centerline)
    size = Size(rod.centerline, laid.factor, drawn.why, laid.added)
    return Centreline(points, laid.slices, size, (*drawn.warnings, *warnings))


def place(points: np.ndarray, rod: Rod) -> np.ndarray:
    """Turn and move a scaled curve to where the scene has it, shape [n, 3]."""
    return rotate(points, rod.rotation.axis, rod.rotation.angle) + np.array(rod.origin)
