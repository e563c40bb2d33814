"""Rods laid into the knot: along a scene's centreline, or as a three-dimensional run has tied them.

What is laid is free of twist but for what its clamped ends hold: with the centreline frozen and nothing rubbing, the
segments turn until the twist is even along the rod, which is its least energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.centerline.frames import tangents, twist_of
from knotfem.errors import InputError
from knotfem.rod.ends import EndFrame
from knotfem.rod.rotation import angle_about, nearest_turn, transport
from knotfem.run.build import Centreline, centreline_of, mesh_of
from knotfem.run.checkpoint import read_checkpoint
from knotfem.run.directory import TIED, RunDirectory
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


@dataclass(frozen=True, eq=False)
class Tied:
    """One rod as it was tied in three dimensions.

    Attributes:
        points: of its axis [mm], shape [sections, 3].
        frames: of its sections, rows d1, d2, t, shape [sections, 3, 3].
    """

    points: np.ndarray
    frames: np.ndarray


def lay(scene: Scene) -> list[LaidRod]:
    """Lay all rods of a scene.

    Raises:
        InputError: a centreline along which no rod can lie, or a source that is no tied run of the same rods.
    """
    if scene.tie.source is not None:
        return [_as_tied(scene, rod, tied) for rod, tied in zip(scene.rods, tied_rods(scene), strict=True)]
    laid = []
    for rod in scene.rods:
        target = centreline_of(rod, rod.slices, scene)
        first = tangents(target.points)[0]
        laid.append(_laid(rod, target, tangents(target.points)[[0, -1]], _across(first), 0.0))
    return laid


def _as_tied(scene: Scene, rod: Rod, tied: Tied) -> LaidRod:
    """The least twisted rod between the ends that the first step clamps as they were tied."""
    held = scene.steps[0].ends[rod.name] if scene.steps else None
    start, end = (
        held is None or isinstance(side, Clamped | Driven) for side in (held and held.start, held and held.end)
    )
    points, ends = _resampled(tied.points, rod.slices), tied.frames[[0, -1]]
    target = Centreline(points)
    free = _laid(rod, target, ends[:, 2], ends[0, 0], 0.0)
    if not end:
        return free
    turns = float(twist_of(tied.frames, tied.points).sum())
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


def tied_rods(scene: Scene) -> list[Tied]:
    """The rods of the run that a scene names as its source, as they were tied.

    Raises:
        InputError: no such run, it is not tied, of another model or of other rods or obstacles.
    """
    source = RunDirectory.open(str(scene.tie.source))
    if source.scene.model != "fem":
        raise InputError("the source is a rod run", file=source.path, key="model", found="rod", expected="fem")
    for key, ours, theirs in (
        ("rods", _shape(scene), _shape(source.scene)),
        ("obstacles", _obstacles(scene), _obstacles(source.scene)),
    ):
        if ours != theirs:
            raise InputError("differs from the scene", file=source.path, key=key, found=str(theirs), expected=str(ours))
    path = source.checkpoints.named(TIED)
    if path is None:
        raise InputError(
            "not tied yet", file=source.path, expected="a run that knotfem tie or pull has brought that far"
        )
    x = np.asarray(read_checkpoint(path).state["progress"]["motion"]["x"])
    tied, first = [], 0
    for rod in source.scene.rods:
        mesh = mesh_of(rod)
        sections = x[mesh.section_nodes + first]
        first += len(mesh.nodes)
        points = sections[:, mesh.section.axis]
        t = tangents(points)
        d = np.einsum("k,ski->si", mesh.nodes[mesh.section_nodes[0], 0], sections - points[:, None])
        d -= np.einsum("si,si->s", d, t)[:, None] * t
        d /= np.linalg.norm(d, axis=1)[:, None]
        tied.append(Tied(points, np.stack([d, np.cross(t, d), t], axis=1)))
    return tied


def _shape(scene: Scene) -> list[tuple[str, float, float]]:
    return [(rod.name, rod.length, rod.diameter) for rod in scene.rods]


def _obstacles(scene: Scene) -> list[tuple]:
    return [(o.diameter, o.point, o.axis) for o in scene.obstacles]
