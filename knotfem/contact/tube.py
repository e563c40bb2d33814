"""Smooth surfaces of hexahedral rods: bi-quadratic B-spline tubes over the boundary nodes.

Along a rod the spline is uniform with straight ghost points beyond its ends, around it periodic. Parameters: u counts
slices, 0 to n; v counts boundary nodes, 0 to k. Over a regular polygon of unit circumradius the tube's radius is
3/4 + 1/4 cos(2 pi/k) at the nodes and cos(pi/k) between, equal to 0.02 % for k = 16. To give the shrinkage back, the
control points stand on the line from the axis node through the boundary node, further out by a constant factor: the
surface stays linear in the positions, and it is the physical one, so that friction acts on its true lever arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.basis import axial_basis, ring_basis
from knotfem.contact.pieces import borders
from knotfem.contact.samples import Samples, SampleView
from knotfem.contact.stations import Stations, make_stations
from knotfem.geometry.rotation import cross, dot, unit
from knotfem.geometry.slices import Slices


class TubeView(NamedTuple):
    """Tubes of all rods, flattened for compiled loops.

    Attributes:
        ring: boundary nodes, section after section, rod after rod.
        ring_start: where each rod begins in `ring`, shape [rods].
        around: boundary nodes of a section, shape [rods].
        sections: of each rod (slices + 1), shape [rods].
        axis: axis nodes, rod after rod.
        axis_start: where each rod begins in `axis`, shape [rods].
        scale: distance of control points over that of boundary nodes from the axis, shape [rods].
    """

    ring: np.ndarray
    ring_start: np.ndarray
    around: np.ndarray
    sections: np.ndarray
    axis: np.ndarray
    axis_start: np.ndarray
    scale: np.ndarray


class TubeRoom(NamedTuple):
    """Work space for one point of a tube.

    Attributes:
        nodes: stencil, shape [12].
        W: weights in S, S_u, S_v, S_uu, S_uv, S_vv, shape [6, 12].
        S: these six, shape [6, 3].
        q: a point minus S, shape [3].
        n: outward unit normal, shape [3].
    """

    nodes: np.ndarray
    W: np.ndarray
    S: np.ndarray
    q: np.ndarray
    n: np.ndarray


@kernel
def tube_room() -> TubeRoom:
    """Work space for one point."""
    return TubeRoom(np.empty(12, np.int64), np.empty((6, 12)), np.empty((6, 3)), np.empty(3), np.empty(3))


@kernel
def stencil(tubes: TubeView, rod: int, u: float, v: float, nodes: np.ndarray, W: np.ndarray) -> None:
    """Nodes (12) of the patch at (u, v) of a rod and their weights W (6, 12) in S, S_u, S_v, S_uu, S_uv, S_vv.

    In each of three sections three boundary nodes and the axis node.
    """
    wu = np.empty((3, 3))
    wv = np.empty((3, 3))
    k = tubes.around[rod]
    c = tubes.scale[rod]
    first = axial_basis(u, tubes.sections[rod], wu)
    middle = ring_basis(v, k, wv)
    for a in range(3):
        row = tubes.ring_start[rod] + (first + a) * k
        for b in range(4):
            p = 4 * a + b
            if b < 3:
                nodes[p] = tubes.ring[row + (middle + b - 1 + k) % k]
                W[0, p] = c * wu[0, a] * wv[0, b]
                W[1, p] = c * wu[1, a] * wv[0, b]
                W[2, p] = c * wu[0, a] * wv[1, b]
                W[3, p] = c * wu[2, a] * wv[0, b]
                W[4, p] = c * wu[1, a] * wv[1, b]
                W[5, p] = c * wu[0, a] * wv[2, b]
            else:
                nodes[p] = tubes.axis[tubes.axis_start[rod] + first + a]
                W[0, p] = (1.0 - c) * wu[0, a]
                W[1, p] = (1.0 - c) * wu[1, a]
                W[2, p] = 0.0
                W[3, p] = (1.0 - c) * wu[2, a]
                W[4, p] = 0.0
                W[5, p] = 0.0


@kernel(inline="always")
def surface_point(x: np.ndarray, nodes: np.ndarray, W: np.ndarray, S: np.ndarray) -> None:
    """S, S_u, S_v, S_uu, S_uv, S_vv into S (6, 3)."""
    for d in range(6):
        for i in range(3):
            S[d, i] = 0.0
    for p in range(nodes.size):
        n = nodes[p]
        for d in range(6):
            for i in range(3):
                S[d, i] += W[d, p] * x[n, i]


@kernel(inline="always")
def tube_normal(S: np.ndarray, n: np.ndarray) -> None:
    """Outward unit normal S_v x S_u into n (3)."""
    cross(S[2], S[1], n)
    unit(n, n)


@kernel(inline="always")
def point_seen(
    x: np.ndarray, tubes: TubeView, rod: int, u: float, v: float, p: np.ndarray, nodes: np.ndarray, room: TubeRoom
) -> None:
    """Stencil of a rod's surface at (u, v) into nodes (12) and W, the point with its derivatives, and q = p - S."""
    stencil(tubes, rod, u, v, nodes, room.W)
    surface_point(x, nodes, room.W, room.S)
    for i in range(3):
        room.q[i] = p[i] - room.S[0, i]


@kernel(error_model="numpy")
def project(
    x: np.ndarray, tubes: TubeView, rod: int, p: np.ndarray, u: float, v: float, room: TubeRoom
) -> tuple[float, float, bool]:
    """Closest point of a tube to p by Newton from (u, v), with its stencil, S and q = p - S in `room`.

    Returns:
        u, v, and whether it converged inside the rod or at most one slice beyond its ends; where the surface folds so
        that Newton's method goes round and round, shorter steps are taken.
    """
    S, q = room.S, room.q
    last = tubes.sections[rod] - 1.0
    largest = np.inf
    for attempt in range(30):
        point_seen(x, tubes, rod, u, v, p, room.nodes, room)
        g1, g2 = dot(q, S[1]), dot(q, S[2])
        a11, a12, a22 = dot(S[1], S[1]), dot(S[1], S[2]), dot(S[2], S[2])
        h11, h12, h22 = a11 - dot(q, S[3]), a12 - dot(q, S[4]), a22 - dot(q, S[5])
        det = h11 * h22 - h12 * h12
        if h11 <= 0.0 or det <= 1e-3 * a11 * a22:
            h11, h12, h22 = a11, a12, a22
            det = h11 * h22 - h12 * h12
        du, dv = (h22 * g1 - h12 * g2) / det, (h11 * g2 - h12 * g1) / det
        if not (abs(du) < 1e3 and abs(dv) < 1e3):
            return u, v, False
        largest = max(abs(du), abs(dv))
        if largest < 1e-13:
            return u, v, True
        if largest < 1e-9:
            u, v = u + du, v + dv
            continue
        scale = min(1.0, (0.7 if attempt < 12 else 0.1) / largest)
        u, v = u + scale * du, v + scale * dv
        if u < -1.0 or u > last + 1.0:
            return min(max(u, -1.0), last + 1.0), v, False
    return u, v, largest < 1e-9


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes of all rods.

    Attributes:
        view: their arrays.
        stations: their cross-sections.
        slices: between these, of each rod.
    """

    view: TubeView
    stations: Stations
    slices: Sequence[Slices]


def spline_radius(around: int) -> float:
    """Mean radius of the periodic quadratic B-spline over a regular polygon of unit circumradius."""
    return 0.5 * (0.75 + 0.25 * np.cos(2 * np.pi / around) + np.cos(np.pi / around))


def make_tubes(
    rings: Sequence[np.ndarray],
    axes: Sequence[np.ndarray],
    slices: Sequence[Slices],
    radius: Sequence[float],
    node_radius: Sequence[float],
) -> Tubes:
    """Tubes over the boundary nodes of rods.

    Args:
        rings: boundary nodes of each rod, shape [sections, around].
        axes: axis nodes of each rod, shape [sections].
        slices: of each rod.
        radius: physical radius [mm].
        node_radius: distance of the boundary nodes from the axis [mm].
    """
    around = np.array([ring.shape[1] for ring in rings], dtype=np.int64)
    sections = np.array([ring.shape[0] for ring in rings], dtype=np.int64)
    ring_start = np.concatenate([[0], np.cumsum(around * sections)[:-1]]).astype(np.int64)
    scale = [r / (n * spline_radius(k)) for r, n, k in zip(radius, node_radius, around, strict=True)]
    axis = np.concatenate(axes).astype(np.int64)
    ring = np.concatenate([ring.ravel() for ring in rings]).astype(np.int64)
    stations = make_stations(axis, slices, radius)
    start = stations.first[:-1].copy()
    view = TubeView(ring, ring_start, around, sections, axis, start, np.array(scale, dtype=float))
    return Tubes(view, stations, list(slices))


@kernel
def _stencils(tubes: TubeView, rod: np.ndarray, at: np.ndarray, nodes: np.ndarray, weights: np.ndarray) -> None:
    W = np.empty((6, 12))
    for s in range(rod.size):
        stencil(tubes, rod[s], at[s, 0], at[s, 1], nodes[s], W)
        weights[s] = W[0]


def make_samples(tubes: Tubes, spacing: float) -> Samples:
    """Samples no further apart than `spacing` [mm] both ways, ends of the rods included."""
    rods, us, vs, areas, starts = [], [], [], [], [0]
    view, stations = tubes.view, tubes.stations
    for rod in range(view.sections.size):
        k, sections = int(view.around[rod]), int(view.sections[rod])
        r, slices = stations.radius[rod], tubes.slices[rod]
        around = k * max(1, int(np.ceil(2 * np.pi * r / k / spacing - 1e-9)))
        u, length = borders(slices, spacing)
        v = np.arange(around) * (k / around)
        area = length * 2 * np.pi * r / around
        us.append(np.repeat(u, around))
        vs.append(np.tile(v, u.size))
        areas.append(np.repeat(area, around))
        rods.append(np.full(u.size * around, rod))
        nearest = np.minimum(np.floor(u + 0.5).astype(int), sections - 1)
        starts.extend(starts[-1] + np.cumsum(np.bincount(nearest, minlength=sections)) * around)
    rod = np.concatenate(rods).astype(np.int64)
    at = np.stack([np.concatenate(us), np.concatenate(vs)], axis=1)
    nodes, weights = np.empty((rod.size, 12), dtype=np.int64), np.empty((rod.size, 12))
    _stencils(view, rod, at, nodes, weights)
    none = np.zeros(rod.size)
    sampled = SampleView(rod, at, nodes, weights, np.zeros((0, 12)), none, np.concatenate(areas), none)
    return Samples(sampled, np.array(starts, dtype=np.int64))
