"""A mapping that does not stretch at all: each tangent follows its great-circle arc to its target."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.tie.direction import resolve_direction
from knotfem.tie.path import Array, check_target, check_time, mean_chord, polyline_stretch, straight_rod

_REPORT_TIMES = np.linspace(0.0, 1.0, 41)


@dataclass(frozen=True, kw_only=True)
class InextensiblePath:
    """Edge i at time t is l_i(t) (cos(t theta_i) E + sin(t theta_i) n_i); the centroid moves on a straight line.

    l_i(t) goes linearly from h to the target's own chord: with equal chords the stretch is 1 at all times, otherwise
    it never deviates further than the target does.

    Attributes:
        target: shape (n + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        angles: theta, from E to the target's edges, shape (n,), rad.
        normals: n, unit vectors across E towards the target's edges, shape (n, 3).
        drift: what moves the target's centroid to the straight rod's, shape (3,), mm.
        seconds: time it took to find.
        kind: name of the mapping.
    """

    target: Array
    direction: Array
    angles: Array
    normals: Array
    drift: Array
    seconds: float
    kind: str = "inextensible"

    @property
    def chord(self) -> float:
        """Edge length h of the straight rod, mm."""
        return mean_chord(self.target)

    def _offsets(self, t: float) -> Array:
        """Returns the vertices relative to vertex 0, shape (n + 1, 3), mm."""
        lengths = (1.0 - t) * self.chord + t * np.linalg.norm(np.diff(self.target, axis=0), axis=1)
        edges = np.cos(t * self.angles)[:, None] * self.direction + np.sin(t * self.angles)[:, None] * self.normals
        return np.concatenate([np.zeros((1, 3)), np.cumsum(lengths[:, None] * edges, axis=0)])

    def at(self, t: float) -> Array:
        """Returns the centreline vertices at mapping time t, shape (n + 1, 3), mm."""
        t = check_time(t)
        move = self._offsets(t) - self._offsets(1.0)
        return self.target + (move - move.mean(axis=0)) + (1.0 - t) * self.drift

    def stretch(self, t: float) -> Array:
        """Returns edge length over h at mapping time t, shape (n,)."""
        return polyline_stretch(self.at(t), self.chord)

    def describe(self) -> dict[str, Any]:
        """Returns direction, largest turn, stretches and curvature at 41 times, and the cost."""
        stretches = np.array([self.stretch(t) for t in _REPORT_TIMES])
        turns = [_largest_turn(self.at(t)) for t in _REPORT_TIMES]
        return {
            "kind": self.kind,
            "direction": self.direction.tolist(),
            "largest_turn_rad": float(self.angles.max()),
            "largest_curvature_over_target": float(max(turns) / turns[-1]) if turns[-1] > 1e-12 else 1.0,
            "min_stretch": float(stretches.min()),
            "max_stretch": float(stretches.max()),
            "max_stretch_deviation": float(np.abs(stretches - 1.0).max()),
            "seconds": self.seconds,
        }


def _largest_turn(points: Array) -> float:
    edges = np.diff(points, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    return float(np.linalg.norm(np.diff(edges, axis=0), axis=1).max())


def inextensible_path(
    target: ArrayLike, *, direction: str | ArrayLike = "best", start: ArrayLike | None = None
) -> InextensiblePath:
    """Turns every edge along its great circle from the straight rod's direction E to the knot's edge.

    Args:
        target: vertices of the knotted centreline, shape (n + 1, 3), mm.
        direction: E, or "best": the one whose largest angle to the target's edges is smallest. Curvature on the way
            exceeds the target's only where edges turn by more than a right angle; `describe` says by how much.
        start: place of the straight rod's first vertex, shape (3,), mm; None puts its middle at the target's centroid.

    Raises:
        InputError: the target, direction or start makes no sense.
    """
    began = time.perf_counter()
    points = check_target(target)
    unit = resolve_direction(direction, points)
    tangents = np.diff(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = tangents - (tangents @ unit)[:, None] * unit
    across -= (across @ unit)[:, None] * unit
    sines = np.linalg.norm(across, axis=1)
    angles = np.arctan2(sines, tangents @ unit)
    normals = np.where(sines[:, None] > 1e-14, across / np.maximum(sines, 1e-300)[:, None], _any_normal(unit))
    straight = straight_rod(points, unit, start)
    return InextensiblePath(
        target=points,
        direction=unit,
        angles=angles,
        normals=normals,
        drift=straight.mean(axis=0) - points.mean(axis=0),
        seconds=time.perf_counter() - began,
    )


def _any_normal(unit: Array) -> Array:
    return np.linalg.svd(unit[None])[2][1]
