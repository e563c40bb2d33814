"""Where the rods of a scene lie when tied, whatever they are modelled by."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from knotfem import shipped
from knotfem.geometry import validate
from knotfem.geometry.curve import interpolate
from knotfem.geometry.finite_rotation import rotate
from knotfem.geometry.readers import read_centreline, unused_columns
from knotfem.geometry.resample import equal_chords
from knotfem.geometry.smoothing import laplacian
from knotfem.scene.model import Scene
from knotfem.scene.rods import CURVE_SUFFIXES, Rod
from knotfem.topology.knot_type import check_smoothing


@dataclass(frozen=True, eq=False)
class Centreline:
    """Where a rod is to lie when tied.

    Attributes:
        points: vertices in equal chords [mm], shape [sections, 3].
        warnings: what deserves one.
    """

    points: np.ndarray
    warnings: tuple[str, ...] = ()


def centrelines_of(scene: Scene) -> list[Centreline]:
    """Centrelines of all rods, which must not overlap where there is contact; see `centreline_of`."""
    found = [centreline_of(rod, rod.slices, scene) for rod in scene.rods]
    if scene.contact.enabled and len(found) > 1:
        lines, rods = [line.points for line in found], scene.rods
        warnings = validate.check_apart(lines, [rod.diameter for rod in rods], [rod.name for rod in rods])
        found[-1] = replace(found[-1], warnings=(*found[-1].warnings, *warnings))
    return found


def centreline_of(rod: Rod, slices: int, scene: Scene) -> Centreline:
    """Read, smooth, scale, resample, place and check a rod's centreline.

    Raises:
        InputError: no rod can lie along it.
    """
    path = rod.centerline if Path(rod.centerline).suffix in CURVE_SUFFIXES else shipped.centreline_path(rod.centerline)
    curve = read_centreline(path)
    unsmoothed = None
    if rod.smoothing.iterations > 0:
        raw = equal_chords(curve, slices, rod.length).points
        unsmoothed = place(raw, rod)
        curve = interpolate(laplacian(raw, rod.smoothing.gamma, rod.smoothing.iterations))
    points = place(equal_chords(curve, slices, rod.length).points, rod)
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
        for name in unused_columns(path)
    ]
    return Centreline(points, tuple(warnings))


def place(points: np.ndarray, rod: Rod) -> np.ndarray:
    """Turn and move a scaled curve to where the scene has it, shape [n, 3]."""
    return rotate(points, rod.rotation.axis, rod.rotation.angle) + np.array(rod.origin)
