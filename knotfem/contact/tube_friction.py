"""Friction between tubes, mobilised over a stick distance, from anchors on the primary surface.

The anchor of a pair is a material point of the primary surface. With q = p - S(anchor), the slip is e = (I - n n^T) q
and the traction T = mu N psi(|e|/s) e/|e|, where n and N belong to the closest point. Its tangent is complete:

    d e = (I - n n^T) dq - dn (n . q) - n (q . dn)
    d n = S^a (B_a^T n - kappa_ab dxi^b)           d xi = H^-1 (B^T S - g B_d^T n)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.anchors import AnchorView, anchor_view
from knotfem.contact.mobilisation import (
    friction_limit,
    mobilisation_energy,
    mobilised,
    slip_stiffness,
    traction_at,
)
from knotfem.contact.pairs import PairContact
from knotfem.contact.samples import SampleView
from knotfem.contact.spread import spread_force
from knotfem.contact.surface import PairView
from knotfem.contact.tube import TubeRoom, TubeView, point_seen, stencil, surface_point, tube_normal, tube_room
from knotfem.contact.tube_pairs import PAD, TubePairRoom, tube_pair_geometry, tube_pair_room
from knotfem.geometry.rotation import across, dot
from knotfem.sparse.scatter import MatrixView, add_blocks


@kernel(error_model="numpy")
def _slip_vector(
    x: np.ndarray, tubes: TubeView, point: np.ndarray, rod: int, anchor: np.ndarray, n: np.ndarray, room: TubeRoom,
    e: np.ndarray,
) -> float:  # fmt: skip
    """Slip e (3) of a pair from its anchor, whose stencil is left in `room`; returns |e|."""
    point_seen(x, tubes, rod, anchor[0], anchor[1], point, room.nodes, room)
    return across(n, room.q, e)


@kernel(inline="always", error_model="numpy")
def _normal_rate(room: TubePairRoom, g: float, column: int, dn: np.ndarray) -> None:
    """Derivative (3, 3) of the normal by one node of the pair."""
    S, n, B, Bd, forms = room.point.S, room.point.n, room.B, room.Bd, room.forms
    a11, a12, a22 = forms[0, 0], forms[0, 1], forms[0, 2]
    det = a11 * a22 - a12 * a12
    for j in range(3):
        c1 = B[column] * S[1, j] - g * Bd[0, column] * n[j]
        c2 = B[column] * S[2, j] - g * Bd[1, column] * n[j]
        xi1 = forms[2, 0] * c1 + forms[2, 1] * c2
        xi2 = forms[2, 1] * c1 + forms[2, 2] * c2
        y1 = Bd[0, column] * n[j] - forms[1, 0] * xi1 - forms[1, 1] * xi2
        y2 = Bd[1, column] * n[j] - forms[1, 1] * xi1 - forms[1, 2] * xi2
        z1, z2 = (a22 * y1 - a12 * y2) / det, (a11 * y2 - a12 * y1) / det
        for i in range(3):
            dn[i, j] = S[1, i] * z1 + S[2, i] * z2


@kernel(error_model="numpy")
def _traction_rates(
    room: TubePairRoom, anchor: TubeRoom, e: np.ndarray, g: float, limits: tuple[float, float], stick: float,
    D: np.ndarray,
) -> None:  # fmt: skip
    """Derivatives D (36, 3, 3) of the traction by the nodes of the pair and of its anchor.

    Args:
        room: of the pair.
        anchor: of its anchor.
        e: slip, shape [3].
        g: gap [mm].
        limits: mu N and its slope with the overlap.
        stick: distance [mm].
        D: filled.
    """
    limit, limit_slope = limits
    n, B = room.point.n, room.B
    dn, de, M = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    psi_y = slip_stiffness(e, limit, stick, M)
    qa = anchor.q
    along = dot(n, qa)
    for c in range(36):
        if c < 24:
            _normal_rate(room, g, c, dn)
        else:
            dn[:] = 0.0
        own = B[c] if c < 12 else (-anchor.W[0, c - 24] if c >= 24 else 0.0)
        for j in range(3):
            qdn = qa[0] * dn[0, j] + qa[1] * dn[1, j] + qa[2] * dn[2, j]
            for i in range(3):
                de[i, j] = own * ((1.0 if i == j else 0.0) - n[i] * n[j]) - along * dn[i, j] - n[i] * qdn
        for i in range(3):
            lost = limit_slope * psi_y / stick * e[i]
            for j in range(3):
                D[c, i, j] = M[i, 0] * de[0, j] + M[i, 1] * de[1, j] + M[i, 2] * de[2, j]
                if c < 24:
                    D[c, i, j] -= lost * B[c] * n[j]


@kernel(error_model="numpy")
def _assemble(
    x: np.ndarray, tubes: TubeView, samples: SampleView, points: np.ndarray, pairs: PairView, friction: AnchorView,
    residual: np.ndarray, matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of the friction of all pairs. False where a block lies outside the pattern."""
    room, anchor = tube_pair_room(), tube_room()
    e, T, D = np.empty(3), np.empty(3), np.empty((36, 3, 3))
    rows, columns, block = np.empty(24, np.int64), np.empty(36, np.int64), np.empty((72, 108))
    for k in range(pairs.sample.size):
        friction.slip[k] = 0.0
        for i in range(3):
            friction.traction[k, i] = 0.0
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        limit, slope = friction_limit(pairs.gap[k], pairs.law, friction.mu[k], samples.measure[s] * pairs.weight[k])
        if limit == 0.0:
            continue
        g = tube_pair_geometry(x, tubes, samples, points[s], s, rod, pairs.at[k], room)
        size = _slip_vector(x, tubes, points[s], rod, friction.anchor[k], room.point.n, anchor, e)
        friction.slip[k] = size
        traction_at(e, size, limit, friction.stick, T)
        for i in range(3):
            friction.traction[k, i] = -T[i]
        spread_force(residual, room.nodes[:12], room.B[:12], 1.0, T)
        spread_force(residual, anchor.nodes, anchor.W[0], -1.0, T)
        if not matrix.wanted:
            continue
        _traction_rates(room, anchor, e, g, (limit, slope), friction.stick, D)
        for a in range(12):
            rows[a], rows[12 + a] = room.nodes[a], anchor.nodes[a]
            columns[a], columns[12 + a], columns[24 + a] = room.nodes[a], room.nodes[12 + a], anchor.nodes[a]
        for a in range(24):
            weight = room.B[a] if a < 12 else -anchor.W[0, a - 12]
            for c in range(36):
                for i in range(3):
                    for j in range(3):
                        block[3 * a + i, 3 * c + j] = weight * D[c, i, j]
        if not add_blocks(matrix, rows, columns, block):
            return False
    return True


@kernel
def _potential(x: np.ndarray, tubes: TubeView, points: np.ndarray, pairs: PairView, friction: AnchorView) -> float:
    room, n, e = tube_room(), np.empty(3), np.empty(3)
    total = 0.0
    for k in range(pairs.sample.size):
        if pairs.force[k] == 0.0:
            continue
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        stencil(tubes, rod, pairs.at[k, 0], pairs.at[k, 1], room.nodes, room.W)
        surface_point(x, room.nodes, room.W, room.S)
        tube_normal(room.S, n)
        size = _slip_vector(x, tubes, points[s], rod, friction.anchor[k], n, room, e)
        total += friction.mu[k] * pairs.force[k] * friction.stick * mobilisation_energy(size / friction.stick)
    return total


@kernel
def _commit(around: np.ndarray, pairs: PairView, friction: AnchorView) -> None:
    """Sliding anchors follow at the stick distance, those of pairs without friction go all the way."""
    for k in range(pairs.sample.size):
        at, anchor = pairs.at[k], friction.anchor[k]
        if pairs.force[k] == 0.0 or friction.mu[k] <= 0.0:
            anchor[0], anchor[1] = at[0], at[1]
        elif friction.slip[k] > friction.stick:
            part = friction.stick / friction.slip[k]
            period = around[pairs.rod[k]]
            turn = anchor[1] - at[1]
            turn -= period * np.round(turn / period)
            anchor[0] = at[0] + part * (anchor[0] - at[0])
            anchor[1] = at[1] + part * turn


@kernel
def _stray_stencils(
    tubes: TubeView, samples: SampleView, pairs: PairView, near: np.ndarray, anchor: np.ndarray, out: np.ndarray
) -> int:
    """Nodes (36) of near pairs whose anchor has left the padded primary patch; returns how many."""
    W, nodes = np.empty((6, 12)), np.empty(12, np.int64)
    count = 0
    for n in range(near.size):
        k: int = near[n]
        rod: int = pairs.rod[k]
        around = tubes.around[rod]
        turn = np.floor(anchor[k, 1] + 0.5) - np.floor(pairs.at[k, 1] + 0.5)
        turn -= around * np.round(turn / around)
        along = np.floor(anchor[k, 0] + 0.5) - np.floor(pairs.at[k, 0] + 0.5)
        if abs(along) <= PAD and abs(turn) <= PAD:
            continue
        stencil(tubes, rod, pairs.at[k, 0], pairs.at[k, 1], nodes, W)
        for a in range(12):
            out[count, a] = samples.nodes[pairs.sample[k], a]
            out[count, 12 + a] = nodes[a]
        stencil(tubes, rod, anchor[k, 0], anchor[k, 1], nodes, W)
        for a in range(12):
            out[count, 24 + a] = nodes[a]
        count += 1
    return count


@dataclass(frozen=True)
class TubeFriction:
    """Friction between tubes; see `knotfem.contact.friction.FrictionLaw`.

    Attributes:
        stick: distance over which friction is mobilised [mm].
    """

    stick: float

    def fresh(self, contact: PairContact, count: int) -> dict[str, np.ndarray]:
        """Anchors."""
        return {"anchor": np.zeros((count, 2))}

    def view(self, contact: PairContact, mu: np.ndarray, rows: dict[str, np.ndarray]) -> AnchorView:
        """See the law."""
        return anchor_view(mu, rows, self.stick)

    def assemble(
        self, x: np.ndarray, contact: PairContact, view: AnchorView, residual: np.ndarray, matrix: MatrixView
    ) -> bool:
        """See the law."""
        surface, samples = contact.surface.view, contact.samples.view
        return _assemble(x, surface, samples, contact.points, contact.pairs, view, residual, matrix)

    def potential(self, x: np.ndarray, contact: PairContact, view: AnchorView) -> float:
        """See the law."""
        return _potential(x, contact.surface.view, contact.samples.places(x), contact.pairs, view)

    def commit(self, x: np.ndarray, contact: PairContact, view: AnchorView) -> None:
        """See the law."""
        _commit(contact.surface.view.around, contact.pairs, view)

    def anchor(self, x: np.ndarray, contact: PairContact, view: AnchorView, chosen: np.ndarray) -> None:
        """See the law."""
        view.anchor[chosen] = contact.pairs.at[chosen]

    def sliding(self, contact: PairContact, view: AnchorView) -> np.ndarray:
        """Whether friction of each pair is fully mobilised, shape [pairs]."""
        return mobilised(view.mu, view.traction, contact.pairs.force)

    def stencils(self, contact: PairContact, view: AnchorView) -> np.ndarray | None:
        """Pairs whose anchor has left the patch that normal contact couples."""
        near = contact.near
        out = np.empty((near.size, 36), dtype=np.int64)
        surface, samples = contact.surface.view, contact.samples.view
        count = _stray_stencils(surface, samples, contact.pairs, near, view.anchor, out)
        return np.unique(out[:count], axis=0)
