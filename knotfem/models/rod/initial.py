"""Rods laid into the knot: along a scene's centreline, or as a three-dimensional run has left them.

What is laid is free of twist but for what its clamped ends hold: with the centreline frozen and nothing rubbing, the
segments turn until the twist is even along the rod, which is its least energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from knotfem.geometry.frames import tangents, twist_of
from knotfem.geometry.rotation import angle_about, nearest_turn, transport
from knotfem.models.centreline import Centreline, centrelines_of
from knotfem.models.rod.ends import EndFrame
from knotfem.models.rod.source import SourceRod, source_rods
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.scene.steps import Clamped, Driven


@dataclass(frozen=True, eq=False)
class LaidRod:
    """One rod of the reduced model.

    Attributes:
        scene: what the user asked for.
        target: its nodes.
        directors: material director of each segment, shape [n, 3].
        ends: how its start and its end lie.
    """

    scene: Rod
    target: Centreline
    directors: np.ndarray
    ends: tuple[EndFrame, EndFrame]


def lay(scene: Scene, folder: Path | None = None) -> list[LaidRod]:
    """Lay all rods of a scene.

    Args:
        scene: what the user asked for.
        folder: of the run, which keeps what it has read of another; see `source_rods`.

    Raises:
        InputError: a centreline along which no rod can lie, or a source that is no tied run of the same rods.
    """
    if scene.tie.source is not None:
        return [_as_left(scene, rod, left) for rod, left in zip(scene.rods, source_rods(scene, folder), strict=True)]
    laid = []
    for rod, target in zip(scene.rods, centrelines_of(scene), strict=True):
        first = tangents(target.points)[0]
        laid.append(_laid(rod, target, tangents(target.points)[[0, -1]], _across(first), 0.0))
    return laid


def _as_left(scene: Scene, rod: Rod, left: SourceRod) -> LaidRod:
    """The least twisted rod between the ends that the first step clamps as the source left them."""
    held = scene.steps[0].ends[rod.name] if scene.steps else None
    start, end = (
        held is None or isinstance(side, Clamped | Driven) for side in (held and held.start, held and held.end)
    )
    points, ends = _resampled(left.points, rod.slices), left.frames[[0, -1]]
    target = Centreline(points)
    free = _laid(rod, target, ends[:, 2], ends[0, 0], 0.0)
    if not end:
        return free
    turns = float(twist_of(left.frames, left.points).sum())
    twist = nearest_turn(angle_about(ends[1, 2], free.ends[1].director, ends[1, 0]), turns)
    if start:
        return _laid(rod, target, ends[:, 2], ends[0, 0], twist)
    turned = np.cos(twist) * ends[0, 0] + np.sin(twist) * np.cross(ends[0, 2], ends[0, 0])
    return _laid(rod, target, ends[:, 2], turned, 0.0)


def _laid(rod: Rod, target: Centreline, ends: np.ndarray, director: np.ndarray, twist: float) -> LaidRod:
    """A rod with the given tangents of its ends, shape [2, 3], director at its start and even twist [rad] in all."""
    edges = np.diff(target.points, axis=0)
    t = np.concatenate([ends[:1], edges / np.linalg.norm(edges, axis=1)[:, None], ends[1:]])
    d = np.empty_like(t)
    d[0] = director
    for j in range(1, len(t)):
        transport(t[j - 1], t[j], d[j - 1], d[j])
    angle = twist * np.concatenate([[0.0], (np.arange(len(edges)) + 0.5) / len(edges), [1.0]])[:, None]
    d = np.cos(angle) * d + np.sin(angle) * np.cross(t, d)
    places = target.points[[0, -1]]
    frames = EndFrame(places[0], t[0], d[0]), EndFrame(places[1], t[-1], d[-1])
    return LaidRod(rod, target, d[1:-1], frames)


def _across(tangent: np.ndarray) -> np.ndarray:
    """The coordinate axis most across a tangent, made normal to it."""
    axis = np.eye(3)[int(np.argmin(np.abs(tangent).round(9)))]
    across = axis - (axis @ tangent) * tangent
    return across / np.linalg.norm(across)


def _resampled(points: np.ndarray, slices: int) -> np.ndarray:
    if len(points) == slices + 1:
        return points
    from scipy.interpolate import CubicSpline

    return CubicSpline(np.linspace(0.0, 1.0, len(points)), points)(np.linspace(0.0, 1.0, slices + 1))
