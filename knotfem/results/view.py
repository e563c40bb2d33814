"""What of a knot fills a picture, and from where it is seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from knotfem.errors import InputError
from knotfem.geometry.clearance import close_strands
from knotfem.geometry.vectors import from_axis
from knotfem.plot.render import Camera
from knotfem.scene.model import Scene

NEAR = 1.3
"""Distance in diameters below which a strand belongs to the knot."""
AT_OBSTACLE = 3.0
"""Gap in diameters below which a crossing is that of a hitch about the obstacle."""
STEEP = 0.95
"""Share of the vertical in a direction from which on z cannot point up in the picture."""
OBLIQUE = 0.3
"""How much a hitch is seen along its obstacle, over how much it is seen from its side."""
Marks = list[np.ndarray]
"""Of the points of each centreline, shape [sections] each."""


def knot_points(scene: Scene, lines: Sequence[np.ndarray]) -> np.ndarray:
    """Points of the centrelines where strands are close to each other, and of hitches to their obstacle [mm].

    Args:
        scene: of the run.
        lines: centrelines of its rods [mm], shape [sections, 3] each.

    Returns:
        Shape [points, 3].

    Raises:
        InputError: there are none.
    """
    knot = _crossings(scene, lines)
    knotted = any(near.any() for near in knot)
    for touching in _touching(scene, lines, NEAR):
        if not knotted or any((near & close).any() for near, close in zip(knot, touching, strict=True)):
            knot = [near | close for near, close in zip(knot, touching, strict=True)]
    points = _marked(lines, knot)
    if len(points) == 0:
        expected = f"strands that come closer than {NEAR:g} diameters to each other or to an obstacle"
        raise InputError("no knot to focus on", key="focus", expected=expected)
    return points


def camera_for(scene: Scene, lines: Sequence[np.ndarray], eye: Sequence[float] | None = None) -> Camera:
    """The view from a direction.

    Args:
        scene: see `knot_points`.
        lines: likewise.
        eye: direction from the knot to the eye; None looks from -y, but at a hitch, most of whose crossings are at
            its obstacle, from the side of the obstacle where these are.

    Raises:
        InputError: no direction.
    """
    if eye is not None:
        given = np.asarray(eye, dtype=np.float64)
        if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
            found = ", ".join(f"{one:g}" for one in eye)
            raise InputError("no direction", key="view", found=found, expected="three numbers, not all 0")
        return _looking(-given)
    crossings = _crossings(scene, lines)
    count = sum(int(near.sum()) for near in crossings)
    for obstacle, touching in zip(scene.obstacles, _touching(scene, lines, AT_OBSTACLE), strict=True):
        both = _marked(lines, [near & close for near, close in zip(crossings, touching, strict=True)])
        if 2 * len(both) <= count:
            continue
        side = from_axis(both, obstacle.point, obstacle.axis).mean(axis=0)
        if np.linalg.norm(side) > 0.25 * obstacle.diameter:
            axis = np.asarray(obstacle.axis) / np.linalg.norm(obstacle.axis)
            return _looking(OBLIQUE * axis - side / np.linalg.norm(side))
    return Camera()


def _looking(direction: np.ndarray) -> Camera:
    """A camera with z upwards; y where it looks along z."""
    steep = abs(direction[2]) > STEEP * np.linalg.norm(direction)
    return Camera(direction=direction, up=(0.0, 1.0, 0.0) if steep else (0.0, 0.0, 1.0))


def _crossings(scene: Scene, lines: Sequence[np.ndarray]) -> Marks:
    """Where strands are close to each other."""
    found: Marks = [close_strands(line, rod.diameter, NEAR) for rod, line in zip(scene.rods, lines, strict=True)]
    for number, (rod, line) in enumerate(zip(scene.rods, lines, strict=True)):
        for other in (*lines[:number], *lines[number + 1 :]):
            found[number] |= KDTree(other).query(line)[0] < NEAR * rod.diameter
    return found


def _touching(scene: Scene, lines: Sequence[np.ndarray], reach: float) -> list[Marks]:
    """For each obstacle where the gap to it is less than so many diameters."""
    return [
        [
            np.linalg.norm(from_axis(line, obstacle.point, obstacle.axis), axis=1) - 0.5 * obstacle.diameter
            < reach * rod.diameter
            for rod, line in zip(scene.rods, lines, strict=True)
        ]
        for obstacle in scene.obstacles
    ]


def _marked(lines: Sequence[np.ndarray], marks: Marks) -> np.ndarray:
    return np.concatenate([line[near] for line, near in zip(lines, marks, strict=True)])
