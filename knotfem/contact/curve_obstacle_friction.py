"""Friction of discrete rods on a rigid surface.

The obstacle has no unknowns of its own; all else is as between rods: slip is that of a material point, friction acts on
the foot of the sample on the obstacle. The derivative of the normal by the sample's place is the Hessian of the
distance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.arms import arm_curvature, arm_gradient, arm_swing
from knotfem.contact.material_frames import Frames, FrameView
from knotfem.contact.material_points import MaterialRoom, material_room
from knotfem.contact.mobilisation import friction_limit, mobilisation_energy, mobilised, slip_stiffness
from knotfem.contact.obstacle import ObstacleContact, TouchView
from knotfem.contact.samples import SampleView
from knotfem.contact.slip import (
    SlipRoom,
    SlipView,
    contact_basis,
    cut_slip,
    slip_rate,
    slip_room,
    slip_view,
    traction_of,
    traction_rate,
    trial_slip,
)
from knotfem.contact.spread import spread_on_arm, spread_rates_on_arm
from knotfem.geometry.rotation import dot
from knotfem.sparse.scatter import MatrixView, add_blocks


class SampleSlipRoom(NamedTuple):
    """Work space for the slip of one sample.

    Attributes:
        point: of the material point.
        slip: of the slip.
    """

    point: MaterialRoom
    slip: SlipRoom


@kernel
def _sample_slip(
    x: np.ndarray, frames: FrameView, samples: SampleView, s: int, n: np.ndarray, friction: SlipView,
    room: SampleSlipRoom,
) -> None:  # fmt: skip
    """Trial slip of a sample into `room`."""
    base, own = samples.nodes[s, 0], friction.own[s]
    material.material_frame(x, base, samples.between[s], frames, own[0], room.point)
    material.material_point(x, base, samples.weights[s], own[1], own[2], room.point, room.slip.z)
    for i in range(3):
        room.slip.z[i] -= friction.anchor[s, i]
    contact_basis(x, base, samples.rates[s], n, room.slip)
    trial_slip(n, friction.stored[s], room.slip)


@kernel
def _assemble(
    x: np.ndarray, frames: FrameView, samples: SampleView, touch: TouchView, friction: SlipView, residual: np.ndarray,
    matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of the friction of samples of discrete rods near an obstacle."""
    room = SampleSlipRoom(material_room(), slip_room())
    slips, G, T, arm = np.empty((3, 12)), np.empty((3, 12)), np.empty(3), np.empty(3)
    for k in range(touch.sample.size):
        s: int = touch.sample[k]
        n = touch.normal[k]
        friction.slip[s] = 0.0
        for i in range(3):
            friction.traction[s, i] = 0.0
        limit, slope = friction_limit(touch.gap[k], touch.law, friction.mu[s], samples.measure[s])
        if limit == 0.0:
            continue
        _sample_slip(x, frames, samples, s, n, friction, room)
        friction.slip[s] = room.slip.size[0]
        base, between = samples.nodes[s, 0], samples.between[s]
        traction_of(room.slip, limit, friction.stick, T)
        distance = touch.gap[k] + samples.offset[s]
        for i in range(3):
            arm[i] = -distance * n[i]
        arm_gradient(base, between, samples.weights[s], frames, arm, room.point, G)
        for i in range(3):
            friction.traction[s, i] = -T[i]
        spread_on_arm(residual, base, G, 1.0, T)
        if not matrix.wanted:
            continue
        slip_stiffness(room.slip.e, limit, friction.stick, room.slip.M)
        law = friction.stick, -slope
        material.material_arm(friction.own[s, 1], friction.own[s, 2], room.point, arm)
        arm_gradient(base, between, samples.weights[s], frames, arm, room.point, slips)
        block = _sample_tangent(samples, s, (n, touch.turn[k]), (slips, G), friction.stored[s], law, room)
        _add_arm(frames, samples, s, (n, touch.turn[k], distance), T, room.point, block)
        if not add_blocks(matrix, samples.nodes[s], samples.nodes[s], block):
            return False
    return True


@kernel
def _sample_tangent(
    samples: SampleView, s: int, normal: tuple[np.ndarray, np.ndarray], gradients: tuple[np.ndarray, np.ndarray],
    stored: np.ndarray, law: tuple[float, float], room: SampleSlipRoom,
) -> np.ndarray:  # fmt: skip
    """Derivatives of the friction force by the unknowns, its arm held, shape [12, 12].

    Args:
        samples: of all rods.
        s: which one.
        normal: of the obstacle, and its derivative.
        gradients: of the material point and of the point on which the force acts, shape [3, 12] each.
        stored: slip of the last accepted step, shape [2].
        law: stick distance, and the limit's slope with the gap.
        room: of the slip.
    """
    n, turn = normal
    slips, G = gradients
    stick, limit_slope = law
    rates, block = np.empty((3, 12)), np.empty((12, 12))
    dz, dn, dalong, de = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for c in range(12):
        node, part = c // 4, c % 4
        dgap = 0.0
        for i in range(3):
            dz[i] = slips[i, c]
            dn[i] = dalong[i] = 0.0
        if part < 3:
            weight = samples.weights[s, node]
            dgap = weight * n[part]
            for i in range(3):
                dn[i] = weight * turn[i, part]
            dalong[part] = samples.rates[s, node]
        slip_rate(n, stored, room.slip, (dz, dn, dalong), de)
        traction_rate(room.slip, stick, de, limit_slope * dgap, rates[:, c])
    spread_rates_on_arm(G, 1.0, rates, block)
    return block


@kernel
def _add_arm(
    frames: FrameView, samples: SampleView, s: int, foot: tuple[np.ndarray, np.ndarray, float], force: np.ndarray,
    room: MaterialRoom, block: np.ndarray,
) -> None:  # fmt: skip
    """Add what the arm of the friction force does to its tangent; `foot` is normal, its derivative and distance."""
    n, turn, distance = foot
    base, between, arm = samples.nodes[s, 0], samples.between[s], np.empty(3)
    H, K = np.empty((12, 12)), np.empty((12, 3))
    for i in range(3):
        arm[i] = -distance * n[i]
    arm_curvature(base, between, frames, arm, force, room, H)
    arm_swing(base, between, frames, force, room, K)
    block += H
    for c in range(12):
        part = c % 4
        if part == 3:
            continue
        weight = samples.weights[s, c // 4]
        for i in range(3):
            arm[i] = -weight * (n[part] * n[i] + distance * turn[i, part])
        for a in range(12):
            block[a, c] += dot(K[a], arm)


@kernel
def _potential(
    x: np.ndarray, frames: FrameView, samples: SampleView, normal: np.ndarray, touch: TouchView, friction: SlipView
) -> float:
    room, total = SampleSlipRoom(material_room(), slip_room()), 0.0
    for k in range(touch.sample.size):
        s: int = touch.sample[k]
        limit = friction.mu[s] * touch.force[s]
        if limit > 0.0:
            _sample_slip(x, frames, samples, s, normal[k], friction, room)
            total += limit * friction.stick * mobilisation_energy(room.slip.size[0] / friction.stick)
    return total


@kernel
def _commit(
    x: np.ndarray, frames: FrameView, samples: SampleView, normal: np.ndarray, force: np.ndarray, friction: SlipView
) -> None:
    """Cut the slip of sliding samples; see `knotfem.contact.curve_friction`."""
    room = SampleSlipRoom(material_room(), slip_room())
    for s in range(force.size):
        if friction.mu[s] * force[s] == 0.0:
            friction.stored[s, 0] = friction.stored[s, 1] = 0.0
            continue
        _sample_slip(x, frames, samples, s, normal[s], friction, room)
        cut_slip(room.slip, friction.stick, friction.stored[s])


@kernel
def _anchor_samples(
    x: np.ndarray, frames: FrameView, samples: SampleView, chosen: np.ndarray, towards: np.ndarray, own: np.ndarray
) -> None:
    """Material coordinates of the chosen samples' contact points, at `towards` (n, 3) from the centreline, into own."""
    room = material_room()
    for k in range(chosen.size):
        s: int = chosen[k]
        base = samples.nodes[s, 0]
        material.material_coordinates(x, base, samples.between[s], frames, towards[k], room, own[s])


@dataclass(frozen=True, eq=False)
class CurveObstacleFriction:
    """Friction of discrete rods on a rigid surface; see `knotfem.contact.friction.FrictionLaw`.

    Attributes:
        frames: of the rods.
        stick: distance over which friction is mobilised [mm].
    """

    frames: Frames
    stick: float

    def fresh(self, contact: ObstacleContact, count: int) -> dict[str, np.ndarray]:
        """Material points, points of the obstacle [mm], slip."""
        return {"own": np.zeros((count, 3)), "anchor": np.zeros((count, 3)), "stored": np.zeros((count, 2))}

    def view(self, contact: ObstacleContact, mu: np.ndarray, rows: dict[str, np.ndarray]) -> SlipView:
        """See the law."""
        return slip_view(mu, rows, self.stick)

    def assemble(
        self, x: np.ndarray, contact: ObstacleContact, view: SlipView, residual: np.ndarray, matrix: MatrixView
    ) -> bool:
        """See the law."""
        return _assemble(x, self.frames.material_view, contact.samples.view, contact.touch, view, residual, matrix)

    def potential(self, x: np.ndarray, contact: ObstacleContact, view: SlipView) -> float:
        """See the law."""
        places = contact.samples.places(x)[contact.touch.sample]
        normal = contact.obstacle.foot(places).normal
        return _potential(x, self.frames.material_view, contact.samples.view, normal, contact.touch, view)

    def commit(self, x: np.ndarray, contact: ObstacleContact, view: SlipView) -> None:
        """See the law."""
        normal, frames = contact.obstacle.foot(contact.points).normal, self.frames.material_view
        _commit(x, frames, contact.samples.view, normal, contact.touch.force, view)
        self.anchor(x, contact, view, np.ones(len(normal), dtype=bool))

    def anchor(self, x: np.ndarray, contact: ObstacleContact, view: SlipView, chosen: np.ndarray) -> None:
        """See the law."""
        points = contact.points[chosen]
        foot = contact.obstacle.foot(points)
        towards = -foot.distance[:, None] * foot.normal
        view.anchor[chosen] = points + towards
        samples = contact.samples.view
        _anchor_samples(x, self.frames.material_view, samples, np.flatnonzero(chosen), towards, view.own)

    def sliding(self, contact: ObstacleContact, view: SlipView) -> np.ndarray:
        """Whether friction of each sample is fully mobilised, shape [samples]."""
        return mobilised(view.mu, view.traction, contact.touch.force)

    def stencils(self, contact: ObstacleContact, view: SlipView) -> np.ndarray | None:
        """None beyond those of normal contact."""
        return None
