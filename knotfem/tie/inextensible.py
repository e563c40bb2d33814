"""Inextensible mapping: each tangent moves on a great circle of the unit sphere to its target."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import perpendicular, unit_edges
from knotfem.tie.direction import resolve_direction
from knotfem.tie.path import CentrelinePath, check_slices, check_target, check_time, straight_rod, stretch_range
from knotfem.types import Array

_REPORT_TIMES = np.linspace(0.0, 1.0, 41)


@dataclass(frozen=True, kw_only=True)
class InextensiblePath(CentrelinePath):
    """Edge i at time t is l_i(t) (cos(t theta_i) E + sin(t theta_i) n_i); the centroid moves on a straight line.

    l_i(t) changes linearly from the length of slice i to the chord of the target. With chords as long as the slices the
    stretch is 1 at all times, with others it deviates from 1 most at t = 1.

    Attributes:
        target: shape (n + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        slices: edges of the straight rod, mm.
        angles: theta between E and the target's edges, shape (n,), rad.
        normals: n, unit vectors perpendicular to E, in the plane of E and the target's edge, shape (n, 3).
        drift: vector from the target's centroid to that of the straight rod, shape (3,), mm.
        seconds: time of the computation, s.
        kind: name of the mapping.
    """

    target: Array
    direction: Array
    slices: Slices
    angles: Array
    normals: Array
    drift: Array
    seconds: float
    kind: str = "inextensible"

    def _offsets(self, t: float) -> Array:
        """Return the vertices relative to vertex 0, shape (n + 1, 3), mm."""
        lengths = (1.0 - t) * self.slices.lengths + t * np.linalg.norm(np.diff(self.target, axis=0), axis=1)
        edges = np.cos(t * self.angles)[:, None] * self.direction + np.sin(t * self.angles)[:, None] * self.normals
        return np.concatenate([np.zeros((1, 3)), np.cumsum(lengths[:, None] * edges, axis=0)])

    def at(self, t: float) -> Array:
        """Return the vertices at mapping time t, shape (n + 1, 3), mm."""
        t = check_time(t)
        move = self._offsets(t) - self._offsets(1.0)
        return self.target + (move - move.mean(axis=0)) + (1.0 - t) * self.drift

    def describe(self) -> dict[str, Any]:
        """Return direction, largest angle, extreme stretches and curvature at 41 mapping times, and computing time."""
        stretches = np.array([self.stretch(t) for t in _REPORT_TIMES])
        turns = [_largest_turn(self.at(t)) for t in _REPORT_TIMES]
        return {
            "kind": self.kind,
            "direction": self.direction.tolist(),
            "largest_turn_rad": float(self.angles.max()),
            "largest_curvature_over_target": float(max(turns) / turns[-1]) if turns[-1] > 1e-12 else 1.0,
            **stretch_range(stretches),
            "seconds": self.seconds,
        }


def _largest_turn(points: Array) -> float:
    """Largest difference of the unit vectors along successive edges, a measure of the curvature."""
    return float(np.linalg.norm(np.diff(unit_edges(points), axis=0), axis=1).max())


def inextensible_path(
    target: ArrayLike,
    *,
    direction: str | ArrayLike = "best",
    start: ArrayLike | None = None,
    slices: Slices | None = None,
) -> InextensiblePath:
    """Inextensible mapping, which rotates every edge from the direction E of the straight rod to its target.

    Args:
        target: vertices of the knotted centreline, shape (n + 1, 3), mm.
        direction: E, or "best" for that whose largest angle to the target's edges is smallest. The curvature exceeds
            that of the target on the way only where edges rotate by more than a right angle; `describe` says by how
            much.
        start: position of the straight rod's first vertex, shape (3,), mm; None puts the rod's middle at the target's
            centroid.
        slices: edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Raises:
        InputError: the target, the direction or the start is not valid.
    """
    began = time.perf_counter()
    points = check_target(target)
    unit, rest = resolve_direction(direction, points), check_slices(slices, points)
    tangents = unit_edges(points)
    across = tangents - (tangents @ unit)[:, None] * unit
    across -= (across @ unit)[:, None] * unit
    sines = np.linalg.norm(across, axis=1)
    angles = np.arctan2(sines, tangents @ unit)
    normals = np.where(sines[:, None] > 1e-14, across / np.maximum(sines, 1e-300)[:, None], perpendicular(unit))
    straight = straight_rod(points, unit, rest, start)
    return InextensiblePath(
        target=points,
        direction=unit,
        slices=rest,
        angles=angles,
        normals=normals,
        drift=straight.mean(axis=0) - points.mean(axis=0),
        seconds=time.perf_counter() - began,
    )
