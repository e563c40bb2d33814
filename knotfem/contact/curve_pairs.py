"""Pairs of discrete rods: closest points of their centrelines, gaps, and the tangent of the gap.

A sample p = b(s) of one rod meets the closest point a(u) of another's smooth centreline: q = p - a, n = q/|q|,
gap = |q| - r_s - r_m. With N the curve's basis, B = [N_s, -N_m], B' = [0, -N_m'] over the three nodes of each, and
h = a' . a' - q . a'',

    du       = [(a' . dp_B) - (q . dp_B')]/h          with dp_B = sum B dx, dp_B' = sum B' dx
    grad gap = B n
    dn       = [(I - n n^T) dp_B - a' du]/|q|
    Hess gap = B dn + B' n du

Each strand is secondary and primary in turn (two half passes): the samples of one press with a line force [N/mm] on the
closest points of the other. On a crossing at right angles two straight strands with the line stiffness k then meet with
the force 4/3 k sqrt(2 d) delta^1.5; k = E*/2, E* = E/(2 (1 - nu^2)), makes it Hertz's 4/3 E* sqrt(r) delta^1.5. That is
the default: the sections do not deform, but they give way as rubber's do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from knotfem.compiled import kernel
from knotfem.contact import surface as protocol
from knotfem.contact.basis import middle_station
from knotfem.contact.curve import CurveRoom, CurveView, curve_room, project
from knotfem.contact.samples import Samples, SampleView
from knotfem.contact.spread import spread_force
from knotfem.contact.stations import make_stations
from knotfem.contact.surface import PairView, SearchLimits, Target
from knotfem.geometry.rotation import dot, unit
from knotfem.mesh.rod_layout import RodLayout
from knotfem.sparse.scatter import add_blocks

LIMITS = SearchLimits(gap=0.6, stale=0.15, coupled=0.6)
PAD = 1
"""Nodes by which the stencils of primary rods are padded in the sparsity, so that contact slides without a new
analysis."""
WIDE_BEND = 0.5
"""Relative difference of the strands' bends towards each other beyond which one of them carries all samples."""
CUP = (0.05, 0.25)
"""A point this near (relative to |q|) to the centre of the other strand's bend has no closest point to speak of."""


def hertz_line_stiffness(youngs_modulus: float, poissons_ratio: float) -> float:
    """Line stiffness [N/mm^2] with which two crossed strands of one material meet by Hertz's law."""
    return 0.25 * youngs_modulus / (1.0 - poissons_ratio**2)


class CurvePairRoom(NamedTuple):
    """Work space for one pair of discrete rods.

    Attributes:
        point: of the closest point.
        n: unit normal, shape [3].
        nodes: secondary, then primary, shape [6].
        B, Bd: shape functions of the gap and of its tangent, shape [6] each.
        du, dn: derivatives of the closest point's u and of the normal by the place of a node, shapes [3], [3, 3].
        block: tangent of the pair, shape [24, 24].
    """

    point: CurveRoom
    n: np.ndarray
    nodes: np.ndarray
    B: np.ndarray
    Bd: np.ndarray
    du: np.ndarray
    dn: np.ndarray
    block: np.ndarray


@kernel
def curve_pair_room() -> CurvePairRoom:
    """Work space for one pair."""
    return CurvePairRoom(
        curve_room(), np.empty(3), np.empty(6, np.int64), np.empty(6), np.empty(6), np.empty(3),
        np.empty((3, 3)), np.zeros((24, 24)),
    )  # fmt: skip


@kernel(inline="always")
def _closest(
    x: np.ndarray, curves: CurveView, samples: SampleView, points: np.ndarray, s: int, rod: int, u: float,
    room: CurveRoom,
) -> tuple[float, float]:  # fmt: skip
    """Where Newton's method from u arrives on a rod, and the gap of sample s there, infinite for no closest point."""
    found, _, inside = project(x, curves, rod, points[s], u, room)
    return found, np.sqrt(dot(room.q, room.q)) - curves.radius[rod] - samples.offset[s] if inside else np.inf


@kernel
def _project_pairs(x: np.ndarray, curves: CurveView, samples: SampleView, points: np.ndarray, pairs: PairView) -> None:
    room = curve_room()
    for k in range(pairs.sample.size):
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        found, gap = _closest(x, curves, samples, points, s, rod, pairs.at[k, 0], room)
        pairs.gap[k] = gap
        if gap < np.inf:
            pairs.at[k, 0] = found


@kernel
def _seek(
    x: np.ndarray, curves: CurveView, samples: SampleView, points: np.ndarray, sought: np.ndarray, gap: np.ndarray,
    at: np.ndarray,
) -> None:  # fmt: skip
    room = curve_room()
    for k in range(sought.shape[0]):
        s: int = sought[k, 0]
        rod: int = sought[k, 1]
        station: int = sought[k, 2]
        at[k, 0], gap[k] = _closest(x, curves, samples, points, s, rod, float(station), room)


@kernel(inline="always")
def _smooth_step(y: float) -> float:
    y = min(max(y, 0.0), 1.0)
    return y * y * (3.0 - 2.0 * y)


@kernel
def _bend(x: np.ndarray, first: int, count: int, u: float, q: np.ndarray, metric: float) -> float:
    """How much a rod bends towards q at u, q . a''/a'^2; where pieces of the curve join, the larger of theirs."""
    middle = middle_station(u, count)
    beside = middle_station(middle + np.sign(u - middle), count)
    here = there = 0.0
    for i in range(3):
        here += q[i] * (x[first + middle - 1, i] - 2.0 * x[first + middle, i] + x[first + middle + 1, i])
        there += q[i] * (x[first + beside - 1, i] - 2.0 * x[first + beside, i] + x[first + beside + 1, i])
    near = min(2.0 * abs(u - middle), 1.0)
    return (here + near * max(there - here, 0.0)) / metric


@kernel
def _pair_weights(
    x: np.ndarray, curves: CurveView, samples: SampleView, points: np.ndarray, pairs: PairView, weight: np.ndarray
) -> None:
    room = curve_room()
    slope, back = np.empty(3), np.empty(3)
    for k in range(pairs.sample.size):
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        first: int = curves.first[rod]
        count = curves.first[rod + 1] - first
        found, _, inside = project(x, curves, rod, points[s], pairs.at[k, 0], room)
        if not inside:
            weight[k] = 0.0
            continue
        for i in range(3):
            slope[i] = 0.0
            back[i] = -room.q[i]
            for a in range(3):
                slope[i] += samples.rates[s, a] * x[samples.nodes[s, a], i]
        secondary: int = samples.rod[s]
        begin: int = curves.first[secondary]
        nodes = curves.first[secondary + 1] - begin
        own = max(1.0 - _bend(x, first, count, found, room.q, dot(room.C[1], room.C[1])), 0.0)
        other = max(1.0 - _bend(x, begin, nodes, samples.at[s, 0], back, dot(slope, slope)), 0.0)
        lean = (own - other) / max(own + other, 1e-300)
        weight[k] = _smooth_step(0.5 + 0.5 * lean / WIDE_BEND) * _smooth_step((own - CUP[0]) / (CUP[1] - CUP[0]))
        weight[k] *= min(max(1.0 + min(found, count - 1.0 - found), 0.0), 1.0)


@kernel
def curve_pair_geometry(
    x: np.ndarray, curves: CurveView, samples: SampleView, point: np.ndarray, s: int, rod: int, u: float,
    room: CurvePairRoom,
) -> tuple[float, float, int]:  # fmt: skip
    """Nodes, B, B' and n of the pair of sample s and a rod into `room`; returns |q|, h and the first primary node."""
    _, base, _ = project(x, curves, rod, point, u, room.point)
    w, C, q = room.point.w, room.point.C, room.point.q
    size = unit(q, room.n)
    for i in range(3):
        room.nodes[i], room.nodes[3 + i] = samples.nodes[s, i], base + i
        room.B[i], room.B[3 + i] = samples.weights[s, i], -w[0, i]
        room.Bd[i], room.Bd[3 + i] = 0.0, -w[1, i]
    return size, dot(C[1], C[1]) - dot(q, C[2]), base


@kernel(inline="always")
def closest_rate(room: CurvePairRoom, c: int, size: float, h: float) -> None:
    """Derivative of the closest point's u by the place of node c of the pair into `du` of `room`."""
    B, Bd, n, slope = room.B[c], room.Bd[c], room.n, room.point.C[1]
    for j in range(3):
        room.du[j] = (B * slope[j] - Bd * size * n[j]) / h


@kernel(inline="always")
def normal_rate(room: CurvePairRoom, c: int, size: float, h: float) -> None:
    """Derivative of the normal by the place of node c of the pair into `dn` of `room`, that of u into `du`."""
    closest_rate(room, c, size, h)
    B, n, slope = room.B[c], room.n, room.point.C[1]
    for i in range(3):
        for j in range(3):
            room.dn[i, j] = (B * ((1.0 if i == j else 0.0) - n[i] * n[j]) - slope[i] * room.du[j]) / size


@kernel
def curve_add_pair(
    x: np.ndarray, curves: CurveView, samples: SampleView, points: np.ndarray, pairs: PairView, k: int, target: Target,
    room: CurvePairRoom,
) -> bool:  # fmt: skip
    """See `knotfem.contact.surface.add_pair`."""
    s, force, slope = pairs.sample[k], pairs.force[k], pairs.slope[k]
    residual, matrix = target
    size, h, _ = curve_pair_geometry(x, curves, samples, points[s], s, pairs.rod[k], pairs.at[k, 0], room)
    n, B, Bd, dn, block = room.n, room.B, room.Bd, room.dn, room.block
    spread_force(residual, room.nodes, B, -force, n)
    if not matrix.wanted:
        return True
    for c in range(6):
        normal_rate(room, c, size, h)
        for a in range(6):
            for i in range(3):
                for j in range(3):
                    bent = B[a] * dn[i, j] + Bd[a] * n[i] * room.du[j]
                    block[4 * a + i, 4 * c + j] = slope * B[a] * n[i] * B[c] * n[j] - force * bent
    return add_blocks(matrix, room.nodes, room.nodes, block)


@kernel
def stencil_nodes(curves: CurveView, samples: SampleView, pairs: PairView, near: np.ndarray, out: np.ndarray) -> None:
    """The sample's three nodes and the padded ones of the primary rod, of each near pair, into out; -1 unused."""
    wide = 3 + 2 * PAD
    for n in range(near.size):
        k: int = near[n]
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        count = curves.first[rod + 1] - curves.first[rod]
        middle = middle_station(pairs.at[k, 0], count)
        for a in range(3):
            out[n, a] = samples.nodes[s, a]
        for a in range(wide):
            j = middle - 1 - PAD + a
            out[n, 3 + a] = curves.first[rod] + j if 0 <= j < count else -1


@kernel
def _normals(
    x: np.ndarray, curves: CurveView, points: np.ndarray, pairs: PairView, chosen: np.ndarray, out: np.ndarray
) -> None:
    room = curve_room()
    for n in range(chosen.size):
        k: int = chosen[n]
        rod: int = pairs.rod[k]
        project(x, curves, rod, points[n], pairs.at[k, 0], room)
        unit(room.q, out[n])


class CurveSurface:
    """The centrelines of all discrete rods as a surface of contact; see `knotfem.contact.surface.Surface`.

    Args:
        layout: of the rods.
    """

    limits, parameters, width = LIMITS, 1, 4

    def __init__(self, layout: RodLayout) -> None:
        radius = np.asarray(layout.radius, dtype=float)
        self.view = CurveView(layout.first, radius)
        slices = [layout.slices(rod) for rod in range(layout.rods)]
        self.stations = make_stations(np.arange(layout.nodes), slices, radius)

    def project(self, x: np.ndarray, samples: SampleView, points: np.ndarray, pairs: PairView) -> None:
        """By Newton's method; parameters stay where there is no closest point."""
        _project_pairs(x, self.view, samples, points, pairs)

    def seek(
        self, x: np.ndarray, samples: SampleView, points: np.ndarray, sought: np.ndarray, reach: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """By Newton's method from the station."""
        gap, at = np.empty(len(sought)), np.empty((len(sought), 1))
        _seek(x, self.view, samples, points, sought, gap, at)
        return gap, at

    def weights(self, x: np.ndarray, samples: Samples, points: np.ndarray, pairs: PairView) -> np.ndarray:
        """Fraction of each sample's length: of the two passes over a contact the better one carries more.

        Where one strand bends round the other, the bent one's samples see a well-defined closest point, while a sample
        of the straight one sits near the centre of the bend. With c_m = 1 - q . a''/a'^2 and c_s the like for the
        secondary strand, the weight goes smoothly from 0 to 1 with (c_m - c_s)/(c_m + c_s); those of the two passes add
        up to 1. It fades where the closest point leaves the end of the primary rod.
        """
        weight = np.empty(pairs.sample.size)
        _pair_weights(x, self.view, samples.view, points, pairs, weight)
        return weight

    def normals(self, x: np.ndarray, points: np.ndarray, pairs: PairView, chosen: np.ndarray) -> np.ndarray:
        """From the closest points of the centrelines."""
        out = np.empty((chosen.size, 3))
        _normals(x, self.view, points, pairs, chosen, out)
        return out

    def stencils(self, samples: Samples, pairs: PairView, near: np.ndarray) -> Sequence[np.ndarray]:
        """Samples with padded primary stencils."""
        nodes = np.empty((near.size, 6 + 2 * PAD), dtype=np.int64)
        stencil_nodes(self.view, samples.view, pairs, near, nodes)
        return [np.unique(nodes, axis=0)]


def _is_curve(view: object) -> bool:
    return getattr(view, "instance_class", None) is CurveView


@overload(protocol.room_of)
def _room_of(surface) -> Callable | None:
    return (lambda surface: curve_pair_room()) if _is_curve(surface) else None


@overload(protocol.add_pair)
def _add_pair(x, surface, samples, points, pairs, k, target, room) -> Callable | None:
    if not _is_curve(surface):
        return None
    return lambda x, surface, samples, points, pairs, k, target, room: curve_add_pair(
        x, surface, samples, points, pairs, k, target, room
    )
