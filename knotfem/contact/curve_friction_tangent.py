"""Tangent of the friction of a pair of discrete rods."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.arms import arm_curvature, arm_swing
from knotfem.contact.curve_pairs import closest_rate, normal_rate
from knotfem.contact.curve_slip import PairSlipRoom
from knotfem.contact.material_frames import FrameView
from knotfem.contact.slip import slip_rate, traction_rate
from knotfem.contact.spread import spread_rates_on_arm
from knotfem.geometry.rotation import dot


@kernel
def pair_tangent(
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
    spread_rates_on_arm(GP, 1.0, D, block[:12])
    spread_rates_on_arm(GA, -1.0, D, block[12:])


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
def add_arms(
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
    slope, by_own, by_other = pair.point.C[1], room.K[0], room.K[1]
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
        B = pair.B[c]
        closest_rate(pair, c, size, h)
        for j in range(3):
            for i in range(3):
                direct = B if i == j else 0.0
                own[i] = -part * (direct - slope[i] * pair.du[j])
                other[i] = own[i] + (direct if c < 3 else 0.0)
            for a in range(12):
                block[a, 4 * c + j] += dot(by_own[a], own)
                block[12 + a, 4 * c + j] -= dot(by_other[a], other)
    for c in range(3):
        for j in range(3):
            for a in range(12):
                block[12 + a, 24 + 4 * c + j] += by_other[a, j] * room.w[0, c]
