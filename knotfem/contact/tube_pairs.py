"""Pairs of tubes: closest points, gaps, and the tangent of the gap.

With q = p - S normal to the surface, metric A, curvature kappa_ab = n . S_ab, H = A - g kappa, and the shape functions
of the secondary and the primary surface in B = [N_s, -N_m], B_a = [0, -N_m,a]:

    grad g = B^T n
    Hess g = -(B^T S_a)(A^-1 kappa H^-1)^ab (B^T S_b)^T + [(B^T S_a) H^ab (B_b^T n)^T + transpose]
             - g (B_a^T n) H^ab (B_b^T n)^T
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from knotfem.compiled import kernel
from knotfem.contact import surface as protocol
from knotfem.contact.basis import middle_station
from knotfem.contact.samples import Samples, SampleView
from knotfem.contact.spread import spread_force
from knotfem.contact.stations import Stations, arclength_at
from knotfem.contact.surface import PairView, SearchLimits, Target
from knotfem.contact.tube import (
    TubeRoom,
    Tubes,
    TubeView,
    point_seen,
    project,
    stencil,
    surface_point,
    tube_normal,
    tube_room,
)
from knotfem.geometry.rotation import dot
from knotfem.sparse.scatter import MatrixView, add_blocks

LIMITS = SearchLimits(gap=0.3, stale=0.117, coupled=0.025)
"""0.9 mm, 0.35 mm and 0.075 mm for a rod of 6 mm. With all pairs in the sparsity a factorisation of the bowline takes
1.5 times the operations, and the run 13 analyses instead of 21."""
SWOLLEN = 1.25
"""Sections may widen by bending and squeezing up to this part of their radius."""
PAD = 1
"""Nodes by which the patches of primary surfaces are padded in the sparsity, so that contact slides without a new
analysis."""


class TubePairRoom(NamedTuple):
    """Work space for one pair of tubes.

    Attributes:
        point: of the closest point.
        nodes: secondary, then primary, shape [24].
        B: shape functions of the gap, shape [24].
        Bd: of its two tangents, shape [2, 24].
        forms: A, kappa and H^-1, each as 11, 12, 22; shape [3, 3].
        T0, T1, T2: parts of the tangent, shapes [3, 3], [2, 3, 3], [2, 2].
        block: tangent of the pair, shape [72, 72].
    """

    point: TubeRoom
    nodes: np.ndarray
    B: np.ndarray
    Bd: np.ndarray
    forms: np.ndarray
    T0: np.ndarray
    T1: np.ndarray
    T2: np.ndarray
    block: np.ndarray


@kernel
def tube_pair_room() -> TubePairRoom:
    """Work space for one pair."""
    return TubePairRoom(
        tube_room(), np.empty(24, np.int64), np.empty(24), np.empty((2, 24)), np.empty((3, 3)), np.empty((3, 3)),
        np.empty((2, 3, 3)), np.empty((2, 2)), np.empty((72, 72)),
    )  # fmt: skip


@kernel
def _project_pairs(x: np.ndarray, tubes: TubeView, points: np.ndarray, pairs: PairView) -> None:
    room = tube_room()
    for k in range(pairs.sample.size):
        s: int = pairs.sample[k]
        u, v, inside = project(x, tubes, pairs.rod[k], points[s], pairs.at[k, 0], pairs.at[k, 1], room)
        pairs.at[k, 0], pairs.at[k, 1], pairs.gap[k] = u, v, np.inf
        if inside:
            tube_normal(room.S, room.n)
            pairs.gap[k] = dot(room.q, room.n)


@kernel
def _start_angle(x: np.ndarray, tubes: TubeView, axis_node: int, rod: int, section: int, p: np.ndarray) -> int:
    """Boundary node of a section that lies most in the direction of p."""
    k = tubes.around[rod]
    best, angle = -np.inf, 0
    for b in range(k):
        node = tubes.ring[tubes.ring_start[rod] + section * k + b]
        value = 0.0
        for i in range(3):
            value += (x[node, i] - x[axis_node, i]) * (p[i] - x[axis_node, i])
        if value > best:
            best, angle = value, b
    return angle


@kernel
def _distance_from_axis(x: np.ndarray, tubes: TubeView, rod: int, j: int, p: np.ndarray) -> float:
    """Distance of p from the edges of a centreline near section j, their lines going on for one edge."""
    start, count = tubes.axis_start[rod], tubes.sections[rod]
    nearest = np.inf
    for k in range(max(j - 3, 0), min(j + 3, count - 1)):
        a, b = tubes.axis[start + k], tubes.axis[start + k + 1]
        e0, e1, e2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        q0, q1, q2 = p[0] - x[a, 0], p[1] - x[a, 1], p[2] - x[a, 2]
        t = min(max((q0 * e0 + q1 * e1 + q2 * e2) / (e0 * e0 + e1 * e1 + e2 * e2), -1.0), 2.0)
        nearest = min(nearest, (q0 - t * e0) ** 2 + (q1 - t * e1) ** 2 + (q2 - t * e2) ** 2)
    return np.sqrt(nearest)


@kernel
def _seek(
    x: np.ndarray, tubes: TubeView, stations: Stations, points: np.ndarray, sought: np.ndarray, reach: float,
    out: tuple[np.ndarray, np.ndarray],
) -> None:  # fmt: skip
    gap, at = out
    room = tube_room()
    longest, w = stations.longest.max(), np.empty((3, 3))
    for k in range(sought.shape[0]):
        s: int = sought[k, 0]
        rod: int = sought[k, 1]
        station: int = sought[k, 2]
        point = points[s]
        at[k, 0], at[k, 1], gap[k] = float(station), 0.0, np.inf
        first: int = tubes.axis_start[rod]
        node: int = tubes.axis[first + station]
        radius = stations.radius[rod]
        d2 = (point[0] - x[node, 0]) ** 2 + (point[1] - x[node, 1]) ** 2 + (point[2] - x[node, 2]) ** 2
        wide = radius + reach + 2.0 * longest
        if d2 > wide * wide or _distance_from_axis(x, tubes, rod, station, point) > SWOLLEN * radius + reach:
            continue
        start = _start_angle(x, tubes, node, rod, station, point)
        u, v, inside = project(x, tubes, rod, point, float(station), float(start), room)
        if not inside:
            continue
        away = abs(arclength_at(stations, rod, u, w) - stations.arclength[first + station])
        if away > 2.0 * radius + stations.longest[rod]:
            continue
        tube_normal(room.S, room.n)
        apart = dot(room.q, room.n)
        if apart >= -radius:
            at[k, 0], at[k, 1], gap[k] = u, v, apart


@kernel(error_model="numpy")
def tube_pair_geometry(
    x: np.ndarray, tubes: TubeView, samples: SampleView, point: np.ndarray, s: int, rod: int, at: np.ndarray,
    room: TubePairRoom,
) -> float:  # fmt: skip
    """Stencil and forms of the pair of sample s and a rod at its closest point into `room`; signed distance n . q."""
    S, q, n = room.point.S, room.point.q, room.point.n
    W, nodes, B, Bd, forms = room.point.W, room.nodes, room.B, room.Bd, room.forms
    point_seen(x, tubes, rod, at[0], at[1], point, nodes[12:], room.point)
    tube_normal(S, n)
    g = dot(q, n)
    for a in range(12):
        nodes[a] = samples.nodes[s, a]
        B[a], Bd[0, a], Bd[1, a] = samples.weights[s, a], 0.0, 0.0
        B[12 + a], Bd[0, 12 + a], Bd[1, 12 + a] = -W[0, a], -W[1, a], -W[2, a]
    forms[0, 0], forms[0, 1], forms[0, 2] = dot(S[1], S[1]), dot(S[1], S[2]), dot(S[2], S[2])
    forms[1, 0], forms[1, 1], forms[1, 2] = dot(n, S[3]), dot(n, S[4]), dot(n, S[5])
    h11 = forms[0, 0] - g * forms[1, 0]
    h12 = forms[0, 1] - g * forms[1, 1]
    h22 = forms[0, 2] - g * forms[1, 2]
    det = h11 * h22 - h12 * h12
    forms[2, 0], forms[2, 1], forms[2, 2] = h22 / det, -h12 / det, h11 / det
    return g


@kernel(error_model="numpy")
def _tangent_parts(g: float, slope: float, force: float, room: TubePairRoom) -> None:
    """Parts of slope grad g grad g - force Hess g into T0, T1, T2 of `room`."""
    S, n, forms, T0, T1, T2 = room.point.S, room.point.n, room.forms, room.T0, room.T1, room.T2
    a11, a12, a22 = forms[0, 0], forms[0, 1], forms[0, 2]
    det = a11 * a22 - a12 * a12
    inv11, inv12, inv22 = a22 / det, -a12 / det, a11 / det
    k11, k12, k22 = forms[1, 0], forms[1, 1], forms[1, 2]
    h11, h12, h22 = forms[2, 0], forms[2, 1], forms[2, 2]
    m11, m12 = inv11 * k11 + inv12 * k12, inv11 * k12 + inv12 * k22
    m21, m22 = inv12 * k11 + inv22 * k12, inv12 * k12 + inv22 * k22
    c11, c12 = m11 * h11 + m12 * h12, m11 * h12 + m12 * h22
    c21, c22 = m21 * h11 + m22 * h12, m21 * h12 + m22 * h22
    c12 = 0.5 * (c12 + c21)
    for i in range(3):
        for j in range(3):
            curved = c11 * S[1, i] * S[1, j] + c22 * S[2, i] * S[2, j] + c12 * (S[1, i] * S[2, j] + S[2, i] * S[1, j])
            T0[i, j] = slope * n[i] * n[j] + force * curved
            T1[0, i, j] = -force * (S[1, i] * h11 + S[2, i] * h12) * n[j]
            T1[1, i, j] = -force * (S[1, i] * h12 + S[2, i] * h22) * n[j]
    T2[0, 0], T2[0, 1], T2[1, 0], T2[1, 1] = force * g * h11, force * g * h12, force * g * h12, force * g * h22


@kernel(error_model="numpy")
def _add_tangent(matrix: MatrixView, room: TubePairRoom) -> bool:
    nodes, n, B, Bd, T0, T1, T2, block = (
        room.nodes, room.point.n, room.B, room.Bd, room.T0, room.T1, room.T2, room.block
    )  # fmt: skip
    upper = matrix.upper
    for a in range(24):
        for b in range(24):
            if upper and nodes[b] < nodes[a]:
                continue
            bb = B[a] * B[b]
            b0, b1 = B[a] * Bd[0, b], B[a] * Bd[1, b]
            d0, d1 = Bd[0, a] * B[b], Bd[1, a] * B[b]
            nn = (
                Bd[0, a] * (T2[0, 0] * Bd[0, b] + T2[0, 1] * Bd[1, b])
                + Bd[1, a] * (T2[1, 0] * Bd[0, b] + T2[1, 1] * Bd[1, b])
            )  # fmt: skip
            for i in range(3):
                for j in range(3):
                    block[3 * a + i, 3 * b + j] = (
                        bb * T0[i, j]
                        + b0 * T1[0, i, j]
                        + b1 * T1[1, i, j]
                        + d0 * T1[0, j, i]
                        + d1 * T1[1, j, i]
                        + nn * n[i] * n[j]
                    )
    return add_blocks(matrix, nodes, nodes, block)


@kernel(error_model="numpy")
def tube_add_pair(
    x: np.ndarray, tubes: TubeView, samples: SampleView, points: np.ndarray, pairs: PairView, k: int, target: Target,
    room: TubePairRoom,
) -> bool:  # fmt: skip
    """See `knotfem.contact.surface.add_pair`."""
    residual, matrix = target
    s, force = pairs.sample[k], pairs.force[k]
    g = tube_pair_geometry(x, tubes, samples, points[s], s, pairs.rod[k], pairs.at[k], room)
    spread_force(residual, room.nodes, room.B, -force, room.point.n)
    if not matrix.wanted:
        return True
    _tangent_parts(g, pairs.slope[k], force, room)
    return _add_tangent(matrix, room)


@kernel
def _patches(tubes: TubeView, samples: SampleView, pairs: PairView, near: np.ndarray, out: np.ndarray) -> None:
    """Secondary and primary patch of each near pair: rods, middle sections and middle nodes."""
    for n in range(near.size):
        k: int = near[n]
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        own: int = samples.rod[s]
        out[n, 0] = own
        out[n, 1] = middle_station(samples.at[s, 0], tubes.sections[own])
        out[n, 2] = int(np.floor(samples.at[s, 1] + 0.5)) % tubes.around[own]
        out[n, 3] = rod
        out[n, 4] = middle_station(pairs.at[k, 0], tubes.sections[rod])
        out[n, 5] = int(np.floor(pairs.at[k, 1] + 0.5)) % tubes.around[rod]


@kernel
def _patch_nodes(tubes: TubeView, patch: np.ndarray, pad: int, out: np.ndarray) -> None:
    """Nodes of secondary patches (3 x 3 nodes) and of primary patches padded by `pad`; -1 unused."""
    out[:] = -1
    for k in range(patch.shape[0]):
        size = 0
        for side in range(2):
            rod, middle, angle = patch[k, 3 * side], patch[k, 3 * side + 1], patch[k, 3 * side + 2]
            extra = 1 + (pad if side == 1 else 0)
            m = tubes.around[rod]
            for a in range(-extra, extra + 1):
                row = middle + a
                if row < 0 or row >= tubes.sections[rod]:
                    continue
                for b in range(-extra, min(extra, m - 1 - extra) + 1):
                    out[k, size] = tubes.ring[tubes.ring_start[rod] + row * m + (angle + b + m) % m]
                    size += 1
                out[k, size] = tubes.axis[tubes.axis_start[rod] + row]
                size += 1


@kernel
def _normals(x: np.ndarray, tubes: TubeView, pairs: PairView, chosen: np.ndarray, out: np.ndarray) -> None:
    room = tube_room()
    for n in range(chosen.size):
        k: int = chosen[n]
        stencil(tubes, pairs.rod[k], pairs.at[k, 0], pairs.at[k, 1], room.nodes, room.W)
        surface_point(x, room.nodes, room.W, room.S)
        tube_normal(room.S, out[n])


class TubeSurface:
    """The tubes of all rods as a surface of contact; see `knotfem.contact.surface.Surface`.

    Args:
        tubes: of all rods.
    """

    limits, parameters, width = LIMITS, 2, 3

    def __init__(self, tubes: Tubes) -> None:
        self.view, self.stations = tubes.view, tubes.stations

    def project(self, x: np.ndarray, samples: SampleView, points: np.ndarray, pairs: PairView) -> None:
        """By Newton's method."""
        _project_pairs(x, self.view, points, pairs)

    def seek(
        self, x: np.ndarray, samples: SampleView, points: np.ndarray, sought: np.ndarray, reach: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """By Newton's method from the boundary node of the section that lies towards the sample."""
        gap, at = np.empty(len(sought)), np.empty((len(sought), 2))
        _seek(x, self.view, self.stations, points, sought, reach, (gap, at))
        return gap, at

    def weights(self, x: np.ndarray, samples: Samples, points: np.ndarray, pairs: PairView) -> np.ndarray:
        """Half, since each strand is secondary and primary in turn, fading from a rod's end to one slice beyond."""
        u, last = pairs.at[:, 0], self.view.sections[pairs.rod] - 1.0
        return 0.5 * np.clip(1.0 + np.minimum(u, last - u), 0.0, 1.0)

    def normals(self, x: np.ndarray, points: np.ndarray, pairs: PairView, chosen: np.ndarray) -> np.ndarray:
        """Of the tubes at the closest points."""
        out = np.empty((chosen.size, 3))
        _normals(x, self.view, pairs, chosen, out)
        return out

    def stencils(self, samples: Samples, pairs: PairView, near: np.ndarray) -> Sequence[np.ndarray]:
        """Secondary patches with padded primary patches."""
        patch = np.empty((near.size, 6), dtype=np.int64)
        _patches(self.view, samples.view, pairs, near, patch)
        patch = np.unique(patch, axis=0)
        wide = 3 + 2 * PAD
        nodes = np.empty((len(patch), 12 + wide * (wide + 1)), dtype=np.int64)
        _patch_nodes(self.view, patch, PAD, nodes)
        return [nodes]


def _is_tube(view: object) -> bool:
    return getattr(view, "instance_class", None) is TubeView


@overload(protocol.room_of)
def _room_of(surface) -> Callable | None:
    return (lambda surface: tube_pair_room()) if _is_tube(surface) else None


@overload(protocol.add_pair)
def _add_pair(x, surface, samples, points, pairs, k, target, room) -> Callable | None:
    if not _is_tube(surface):
        return None
    return lambda x, surface, samples, points, pairs, k, target, room: tube_add_pair(
        x, surface, samples, points, pairs, k, target, room
    )
