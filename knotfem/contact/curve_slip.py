"""Slip of a pair of discrete rods, and the arms at which their friction acts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.basis import axial_basis
from knotfem.contact.curve import CurveView, between_middles
from knotfem.contact.curve_pairs import CurvePairRoom, curve_pair_geometry, curve_pair_room
from knotfem.contact.material_frames import FrameView
from knotfem.contact.material_points import MaterialRoom, material_room
from knotfem.contact.samples import SampleView
from knotfem.contact.slip import SlipRoom, SlipView, contact_basis, slip_room, trial_slip
from knotfem.contact.surface import PairView


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
def pair_slip_room() -> PairSlipRoom:
    """Work space for one pair."""
    return PairSlipRoom(
        curve_pair_room(), material_room(), material_room(), np.empty((3, 3)), slip_room(), np.empty((2, 3)),
        np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((3, 3, 3)), np.empty(3), np.empty((3, 36)),
        np.empty((24, 36)), np.empty((12, 12)), np.empty((2, 12, 3)), np.empty((2, 3)), np.empty((2, 3, 12)),
        np.empty((2, 3, 12)),
    )  # fmt: skip


@kernel
def pair_slip(
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
    contact_basis(x, base, samples.rates[s], room.pair.n, room.slip)
    trial_slip(room.pair.n, friction.stored[k], room.slip)
    return size, h, ahead


@kernel
def touching_arms(x: np.ndarray, point: np.ndarray, ahead: int, part: float, room: PairSlipRoom) -> None:
    """Vectors from both curves to where the rods touch now, at a part of the distance of their axes."""
    q, w = room.pair.point.q, room.w
    for i in range(3):
        room.arms[0, i] = -part * q[i]
        there = w[0, 0] * x[ahead, i] + w[0, 1] * x[ahead + 1, i] + w[0, 2] * x[ahead + 2, i]
        room.arms[1, i] = point[i] - part * q[i] - there
