"""Friction between discrete rods, mobilised over a stick distance.

A pair remembers one material point of each rod that lay where they touch when the last step was accepted, and the slip
of then. With z their difference now (secondary minus primary), T = I - n n^T and (g1, g2) the basis of the
contact plane along the secondary rod's tangent and across it,

    e = T z + e1 g1 + e2 g2          trial slip
    traction = mu N psi(|e|/s) e/|e|

with psi of `knotfem.contact.mobilisation`, as between tubes, rolling and twisting included. The force acts on both rods
at the point between their axes where they touch now (`knotfem.contact.arms`). On an accepted step the slip is cut to
the stick distance s where the pair slides, and both material points are reset to the current contact point, so that the
contact may move along the rods and roll without end, while slip that is not cut stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.arms import arm_curvature, arm_gradient, arm_swing
from knotfem.contact.basis import axial_basis
from knotfem.contact.curve import CurveView, between_middles
from knotfem.contact.curve_pairs import (
    PAD,
    CurvePairRoom,
    curve_pair_geometry,
    curve_pair_room,
    normal_rate,
    stencil_nodes,
)
from knotfem.contact.law import penalty
from knotfem.contact.material_frames import Frames, FrameView
from knotfem.contact.material_points import MaterialRoom, material_room
from knotfem.contact.mobilisation import mobilisation_energy, mobilised, slip_stiffness
from knotfem.contact.pairs import PairContact
from knotfem.contact.samples import SampleView
from knotfem.contact.slip import (
    SlipRoom,
    SlipView,
    contact_basis,
    cut_slip,
    slip_rate,
    slip_room,
    traction_of,
    traction_rate,
    trial_slip,
)
from knotfem.contact.surface import PairView
from knotfem.geometry.rotation import dot
from knotfem.sparse.scatter import MatrixView, add_blocks


class PairSlipRoom(NamedTuple):
    """Work space for the slip of one pair.

    Attributes:
        pair: of its closest point.
        own, other: of the two material points.
        w: weights of the primary rod's material point, shape [3, 3].
        slip: of the slip.
        points: the two material points, shape [2, 3].
        rates: of z, n and the secondary rod's derivative, shape [3, 3].
        de, dt: of slip and traction, shape [3] each.
        by: derivatives of the traction by these three, shape [3, 3, 3].
        by_limit: by the gap, shape [3].
        D: by all unknowns, shape [3, 36].
        block: of the forces on the two rods, shape [24, 36].
        H: of the forces on one rod by its own unknowns, shape [12, 12].
        K: of the forces on both rods by their arms, shape [2, 12, 3].
        arms: of the force on the two rods, shape [2, 3].
        slips, forces: gradients of the material points and of the points on which the force acts, shape [2, 3, 12].
    """

    pair: CurvePairRoom
    own: MaterialRoom
    other: MaterialRoom
    w: np.ndarray
    slip: SlipRoom
    points: np.ndarray
    rates: np.ndarray
    de: np.ndarray
    dt: np.ndarray
    by: np.ndarray
    by_limit: np.ndarray
    D: np.ndarray
    block: np.ndarray
    H: np.ndarray
    K: np.ndarray
    arms: np.ndarray
    slips: np.ndarray
    forces: np.ndarray


@kernel
def _pair_slip_room() -> PairSlipRoom:
    return PairSlipRoom(
        curve_pair_room(), material_room(), material_room(), np.empty((3, 3)), slip_room(), np.empty((2, 3)),
        np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((3, 3, 3)), np.empty(3), np.empty((3, 36)),
        np.empty((24, 36)), np.empty((12, 12)), np.empty((2, 12, 3)), np.empty((2, 3)), np.empty((2, 3, 12)),
        np.empty((2, 3, 12)),
    )  # fmt: skip


@kernel
def _pair_slip(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, points: np.ndarray,
    pair: tuple[PairView, int], friction: SlipView, room: PairSlipRoom,
) -> tuple[float, float, int]:  # fmt: skip
    """Trial slip of one pair into `room`; returns |q|, h of `curve_pair_geometry` and the anchor's first node."""
    pairs, k = pair
    s: int = pairs.sample[k]
    rod: int = pairs.rod[k]
    first: int = curves.first[rod]
    count: int = curves.first[rod + 1] - first
    size, h, _ = curve_pair_geometry(x, curves, samples, points[s], s, rod, pairs.at[k, 0], room.pair)
    base: int = samples.nodes[s, 0]
    own, anchor = friction.own[k], friction.anchor[k]
    material.material_frame(x, base, samples.between[s], frames, own[0], room.own)
    material.material_point(x, base, samples.weights[s], own[1], own[2], room.own, room.points[0])
    local = axial_basis(friction.u[k], count, room.w)
    ahead = first + local
    material.material_frame(x, ahead, between_middles(friction.u[k], local), frames, anchor[0], room.other)
    material.material_point(x, ahead, room.w[0], anchor[1], anchor[2], room.other, room.points[1])
    for i in range(3):
        room.slip.z[i] = room.points[0, i] - room.points[1, i]
    contact_basis(x, base, samples.rates[s, 0], room.pair.n, room.slip)
    trial_slip(room.pair.n, friction.stored[k], room.slip)
    return size, h, ahead


@kernel
def _assemble(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    friction: SlipView, residual: np.ndarray, matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of the friction of all pairs. False where a block lies outside the pattern."""
    points, pairs = contact
    room = _pair_slip_room()
    T, arm = np.empty(3), np.empty(3)
    GP, GA = room.forces[0], room.forces[1]
    rows, columns = np.empty(6, np.int64), np.empty(9, np.int64)
    for k in range(pairs.sample.size):
        s: int = pairs.sample[k]
        friction.slip[k] = 0.0
        for i in range(3):
            friction.traction[k, i] = 0.0
        _, pressure, slope = penalty(pairs.gap[k], pairs.law)
        carried = samples.measure[s] * pairs.weight[k]
        if carried * pressure == 0.0 or friction.mu[k] == 0.0:
            continue
        size, h, ahead = _pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
        friction.slip[k] = room.slip.size[0]
        own, anchor = friction.own[k], friction.anchor[k]
        base: int = samples.nodes[s, 0]
        limit = friction.mu[k] * carried * pressure
        traction_of(room.slip, limit, friction.stick, T)
        rod: int = pairs.rod[k]
        between, lies = samples.between[s], between_middles(friction.u[k], ahead - curves.first[rod])
        part = samples.offset[s] / (samples.offset[s] + curves.radius[rod])
        _arms(x, points[s], ahead, part, room)
        arm_gradient(base, between, samples.weights[s], frames, room.arms[0], room.own, GP)
        arm_gradient(ahead, lies, room.w[0], frames, room.arms[1], room.other, GA)
        for i in range(3):
            friction.traction[k, i] = -T[i]
            rows[i] = columns[i] = base + i
            columns[3 + i] = room.pair.nodes[3 + i]
            rows[3 + i] = columns[6 + i] = ahead + i
        for c in range(12):
            residual[rows[c // 4], c % 4] += GP[0, c] * T[0] + GP[1, c] * T[1] + GP[2, c] * T[2]
            residual[rows[3 + c // 4], c % 4] -= GA[0, c] * T[0] + GA[1, c] * T[1] + GA[2, c] * T[2]
        if not matrix.wanted:
            continue
        slip_stiffness(room.slip.e, limit, friction.stick, room.slip.M)
        law = friction.stick, -friction.mu[k] * carried * slope
        material.material_arm(own[1], own[2], room.own, arm)
        arm_gradient(base, between, samples.weights[s], frames, arm, room.own, room.slips[0])
        material.material_arm(anchor[1], anchor[2], room.other, arm)
        arm_gradient(ahead, lies, room.w[0], frames, arm, room.other, room.slips[1])
        _pair_tangent(room, samples.rates[s, 0], friction.stored[k], (size, h), law)
        _add_arms(frames, (base, between, ahead, lies), (size, h, part), room, T)
        if not add_blocks(matrix, rows, columns, room.block):
            return False
    return True


@kernel
def _pair_tangent(
    room: PairSlipRoom, rates: np.ndarray, stored: np.ndarray, geometry: tuple[float, float], law: tuple[float, float]
) -> None:
    """Derivatives of the forces on both rods by all unknowns into `block`, the arms held.

    The traction depends on them through the difference z of the two points, the normal n, the secondary rod's
    derivative and the limit; its derivatives by these are found once and applied to those of each unknown.

    Args:
        room: of the pair.
        rates: weights of the secondary rod's derivative, shape [3].
        stored: slip of the last accepted step, shape [2].
        geometry: |q| and h.
        law: stick distance, and the limit's slope with the gap.
    """
    SP, SA, GP, GA = room.slips[0], room.slips[1], room.forces[0], room.forces[1]
    size, h = geometry
    pair, n, D, block = room.pair, room.pair.n, room.D, room.block
    by_z, by_n, by_along, by_limit = room.by[0], room.by[1], room.by[2], room.by_limit
    _traction_rates(room, stored, law)
    for c in range(12):
        node, part = c // 4, c % 4
        for i in range(3):
            D[i, c] = by_z[i, 0] * SP[0, c] + by_z[i, 1] * SP[1, c] + by_z[i, 2] * SP[2, c]
            D[i, 12 + c] = 0.0
            D[i, 24 + c] = -(by_z[i, 0] * SA[0, c] + by_z[i, 1] * SA[1, c] + by_z[i, 2] * SA[2, c])
            if part < 3:
                D[i, c] += by_along[i, part] * rates[node]
    for node in range(6):
        normal_rate(pair, node, size, h)
        dn, B = pair.dn, pair.B[node]
        for part in range(3):
            for i in range(3):
                rate = by_n[i, 0] * dn[0, part] + by_n[i, 1] * dn[1, part] + by_n[i, 2] * dn[2, part]
                D[i, 4 * node + part] += rate + by_limit[i] * B * n[part]
    for a in range(12):
        for c in range(36):
            block[a, c] = GP[0, a] * D[0, c] + GP[1, a] * D[1, c] + GP[2, a] * D[2, c]
            block[12 + a, c] = -(GA[0, a] * D[0, c] + GA[1, a] * D[1, c] + GA[2, a] * D[2, c])


@kernel
def _traction_rates(room: PairSlipRoom, stored: np.ndarray, law: tuple[float, float]) -> None:
    """Derivatives of the traction by z, n and the secondary rod's derivative into `by`, by the gap into `by_limit`."""
    stick, limit_slope = law
    rates, de, dt, by = room.rates, room.de, room.dt, room.by
    for kind in range(3):
        for j in range(3):
            rates[:] = 0.0
            rates[kind, j] = 1.0
            slip_rate(room.pair.n, stored, room.slip, (rates[0], rates[1], rates[2]), de)
            traction_rate(room.slip, stick, de, 0.0, dt)
            for i in range(3):
                by[kind, i, j] = dt[i]
    de[:] = 0.0
    traction_rate(room.slip, stick, de, limit_slope, room.by_limit)


@kernel
def _arms(x: np.ndarray, point: np.ndarray, ahead: int, part: float, room: PairSlipRoom) -> None:
    """Vectors from both curves to where the rods touch now, at a part of the distance of their axes."""
    q, w = room.pair.point.q, room.w
    for i in range(3):
        room.arms[0, i] = -part * q[i]
        there = w[0, 0] * x[ahead, i] + w[0, 1] * x[ahead + 1, i] + w[0, 2] * x[ahead + 2, i]
        room.arms[1, i] = point[i] - part * q[i] - there


@kernel
def _add_arms(
    frames: FrameView, where: tuple[int, float, int, float], geometry: tuple[float, float, float], room: PairSlipRoom,
    T: np.ndarray,
) -> None:  # fmt: skip
    """Add what the arms of the forces T and -T do to their tangent.

    Args:
        frames: of the rods.
        where: first node and place between two edges of both rods.
        geometry: |q|, h and the part of the distance at which the rods touch.
        room: of the pair.
        T: friction force.
    """
    base, between, ahead, lies = where
    size, h, part = geometry
    pair, H, block, own, other = room.pair, room.H, room.block, room.de, room.dt
    n, slope, by_own, by_other = pair.n, pair.point.C[1], room.K[0], room.K[1]
    arm_swing(base, between, frames, T, room.own, by_own)
    arm_swing(ahead, lies, frames, T, room.other, by_other)
    arm_curvature(base, between, frames, room.arms[0], T, room.own, H)
    for a in range(12):
        for c in range(12):
            block[a, c] += H[a, c]
    arm_curvature(ahead, lies, frames, room.arms[1], T, room.other, H)
    for a in range(12):
        for c in range(12):
            block[12 + a, 24 + c] -= H[a, c]
    for c in range(6):
        B, Bd = pair.B[c], pair.Bd[c]
        for j in range(3):
            du = (B * slope[j] - Bd * size * n[j]) / h
            for i in range(3):
                direct = B if i == j else 0.0
                own[i] = -part * (direct - slope[i] * du)
                other[i] = own[i] + (direct if c < 3 else 0.0)
            for a in range(12):
                block[a, 4 * c + j] += dot(by_own[a], own)
                block[12 + a, 4 * c + j] -= dot(by_other[a], other)
    for c in range(3):
        for j in range(3):
            for a in range(12):
                block[12 + a, 24 + 4 * c + j] += by_other[a, j] * room.w[0, c]


@kernel
def _potential(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    friction: SlipView,
) -> float:  # fmt: skip
    """Friction potential with the normal forces last assembled."""
    points, pairs = contact
    room = _pair_slip_room()
    total = 0.0
    for k in range(pairs.sample.size):
        limit = friction.mu[k] * pairs.force[k]
        if limit == 0.0:
            continue
        _pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
        total += limit * friction.stick * mobilisation_energy(room.slip.size[0] / friction.stick)
    return total


@kernel
def _anchor_pairs(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    chosen: np.ndarray, friction: SlipView,
) -> None:  # fmt: skip
    """Reset both material points of the chosen pairs to the current contact point between the axes.

    It divides the distance of the axes as the radii do: two rods that roll on each other rotate inversely as those.
    """
    points, pairs = contact
    room, frame, d = curve_pair_room(), material_room(), np.empty(3)
    for k in range(pairs.sample.size):
        if not chosen[k]:
            continue
        s: int = pairs.sample[k]
        rod: int = pairs.rod[k]
        _, _, base = curve_pair_geometry(x, curves, samples, points[s], s, rod, pairs.at[k, 0], room)
        q, part = room.point.q, samples.offset[s] / (samples.offset[s] + curves.radius[rod])
        for i in range(3):
            d[i] = -part * q[i]
        material.material_coordinates(x, samples.nodes[s, 0], samples.between[s], frames, d, frame, friction.own[k])
        for i in range(3):
            d[i] = (1.0 - part) * q[i]
        friction.u[k] = pairs.at[k, 0]
        lies = between_middles(pairs.at[k, 0], base - curves.first[rod])
        material.material_coordinates(x, base, lies, frames, d, frame, friction.anchor[k])


@kernel
def _commit(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    friction: SlipView,
) -> None:  # fmt: skip
    """Cut the slip of sliding pairs, and forget that of pairs without friction."""
    points, pairs = contact
    room = _pair_slip_room()
    for k in range(pairs.sample.size):
        if friction.mu[k] * pairs.force[k] == 0.0:
            friction.stored[k, 0] = friction.stored[k, 1] = 0.0
            continue
        _pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
        cut_slip(room.slip, friction.stick, friction.stored[k])


@dataclass(frozen=True, eq=False)
class CurveFriction:
    """Friction between discrete rods; see `knotfem.contact.friction.FrictionLaw`.

    Attributes:
        frames: of the rods.
        stick: distance over which friction is mobilised [mm].
    """

    frames: Frames
    stick: float

    def fresh(self, contact: PairContact, count: int) -> dict[str, np.ndarray]:
        """Material points and slip."""
        return {
            "own": np.zeros((count, 3)),
            "u": np.zeros(count),
            "anchor": np.zeros((count, 3)),
            "stored": np.zeros((count, 2)),
        }

    def view(self, contact: PairContact, mu: np.ndarray, rows: dict[str, np.ndarray]) -> SlipView:
        """See the law."""
        slip, traction = np.zeros(mu.size), np.zeros((mu.size, 3))
        return SlipView(mu, rows["own"], rows["u"], rows["anchor"], rows["stored"], slip, traction, self.stick)

    def assemble(
        self, x: np.ndarray, contact: PairContact, view: SlipView, residual: np.ndarray, matrix: MatrixView
    ) -> bool:
        """See the law."""
        where = contact.points, contact.pairs
        surface, samples = contact.surface.view, contact.samples.view
        return _assemble(x, self.frames.material_view, surface, samples, where, view, residual, matrix)

    def potential(self, x: np.ndarray, contact: PairContact, view: SlipView) -> float:
        """See the law."""
        where = contact.samples.places(x), contact.pairs
        return _potential(x, self.frames.material_view, contact.surface.view, contact.samples.view, where, view)

    def commit(self, x: np.ndarray, contact: PairContact, view: SlipView) -> None:
        """See the law."""
        where, surface = (contact.points, contact.pairs), contact.surface.view
        _commit(x, self.frames.material_view, surface, contact.samples.view, where, view)
        self.anchor(x, contact, view, np.isfinite(contact.pairs.gap))

    def anchor(self, x: np.ndarray, contact: PairContact, view: SlipView, chosen: np.ndarray) -> None:
        """See the law."""
        where, surface = (contact.points, contact.pairs), contact.surface.view
        _anchor_pairs(x, self.frames.material_view, surface, contact.samples.view, where, chosen, view)

    def sliding(self, contact: PairContact, view: SlipView) -> np.ndarray:
        """Whether friction of each pair is fully mobilised, shape [pairs]."""
        return mobilised(view.mu, view.traction, contact.pairs.force)

    def stencils(self, contact: PairContact, view: SlipView) -> np.ndarray | None:
        """Nodes of the padded pairs and of their anchors."""
        near, pairs, curves = contact.near, contact.pairs, contact.surface.view
        out = np.empty((near.size, 9 + 2 * PAD), dtype=np.int64)
        stencil_nodes(curves, contact.samples.view, pairs, near, out)
        first, count = curves.first[pairs.rod[near]], np.diff(curves.first)[pairs.rod[near]]
        middle = np.clip(np.floor(view.u[near] + 0.5).astype(np.int64), 1, count - 2)
        out[:, -3:] = (first + middle)[:, None] + np.arange(-1, 2)
        return np.unique(out, axis=0)
