"""Initial configuration of discrete rods: along a scene's centreline, or as a three-dimensional run has left them.

It is free of twist but for what its clamped ends hold, be it given by the scene or left by a run. With the centreline
fixed and no friction, the segments rotate until the twist is uniform along the rod, which is its least energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.geometry.finite_rotation import parallel_transport, rotate
from knotfem.geometry.frames import tangents, twist_of
from knotfem.geometry.rotation import angle_about, nearest_turn
from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import perpendicular, unit_edges
from knotfem.models.centreline import Centreline, centrelines_of, slices_of
from knotfem.models.curve_size import Size
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Clamped, Driven


@dataclass(frozen=True, eq=False)
class EndFrame:
    """Tangent (in the direction of the arclength) and material director of an end, shape [3] each."""

    tangent: np.ndarray
    director: np.ndarray


@dataclass(frozen=True, eq=False)
class SourceRod:
    """One rod as a three-dimensional run has left it.

    Attributes:
        points: of its axis [mm], shape [sections, 3].
        fractions: arclength over the length of the rod, shape [sections].
        frames: of its sections, rows d1, d2, t, shape [sections, 3, 3].
    """

    points: np.ndarray
    fractions: np.ndarray
    frames: np.ndarray


@dataclass(frozen=True, eq=False)
class InitialRod:
    """Initial configuration of one rod.

    Attributes:
        target: its nodes.
        directors: material director of each segment, shape [n, 3].
        ends: orientation of its start and of its end.
    """

    target: Centreline
    directors: np.ndarray
    ends: tuple[EndFrame, EndFrame]


def initial_rods(scene: Scene, source: Sequence[SourceRod] = ()) -> list[InitialRod]:
    """Initial configuration of all rods of a scene.

    Args:
        scene: what the user asked for.
        source: as another run has left them, instead of the scene's centrelines; or none.

    Raises:
        InputError: a centreline along which no rod can lie.
    """
    if source:
        parts = zip(scene.rods, source, slices_of(scene), strict=True)
        return [_as_left(scene, rod, left, slices) for rod, left, slices in parts]
    found = []
    for rod, target in zip(scene.rods, centrelines_of(scene), strict=True):
        t = tangents(target.points)
        found.append(_initial(target, t[[0, -1]], perpendicular(t[0]), rod.twist))
    return found


def _as_left(scene: Scene, rod: Rod, left: SourceRod, slices: Slices) -> InitialRod:
    """The least twisted rod between the ends that the first step clamps as the source left them."""
    held = scene.steps[0].ends[rod.name] if scene.steps else None
    start, end = (
        held is None or isinstance(side, Clamped | Driven) for side in (held and held.start, held and held.end)
    )
    size = Size(rod.centerline, None, f"as the run {scene.tie.source} has left it")
    target, ends = Centreline(_resampled(left, slices), slices, size), left.frames[[0, -1]]
    free = _initial(target, ends[:, 2], ends[0, 0], 0.0)
    if not end:
        return free
    turns = float(twist_of(left.frames, left.points).sum())
    twist = nearest_turn(angle_about(ends[1, 2], free.ends[1].director, ends[1, 0]), turns)
    if start:
        return _initial(target, ends[:, 2], ends[0, 0], twist)
    return _initial(target, ends[:, 2], rotate(ends[0, 0], ends[0, 2], twist), 0.0)


def _initial(target: Centreline, ends: np.ndarray, director: np.ndarray, twist: float) -> InitialRod:
    """A rod with the given tangents of its ends, shape [2, 3], director at its start and uniform twist [rad] in all."""
    edges = unit_edges(target.points)
    t = np.concatenate([ends[:1], edges, ends[1:]])
    d = parallel_transport(t, director)
    if twist != 0.0:
        d = rotate(d, t, twist * np.concatenate([[0.0], target.slices.middles, [1.0]]))
    return InitialRod(target, d[1:-1], (EndFrame(t[0], d[0]), EndFrame(t[-1], d[-1])))


def _resampled(left: SourceRod, slices: Slices) -> np.ndarray:
    """Material points of the axis at other cross-sections [mm], shape [slices + 1, 3]."""
    if left.fractions.size == slices.count + 1 and np.allclose(left.fractions, slices.fractions, rtol=0.0, atol=1e-12):
        return left.points
    from scipy.interpolate import CubicSpline

    return CubicSpline(left.fractions, left.points)(slices.fractions)
