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

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.arms import arm_gradient
from knotfem.contact.curve import CurveView, between_middles
from knotfem.contact.curve_friction_tangent import add_arms, pair_tangent
from knotfem.contact.curve_pairs import PAD, curve_pair_geometry, curve_pair_room, stencil_nodes
from knotfem.contact.curve_slip import pair_slip, pair_slip_room, touching_arms
from knotfem.contact.material_frames import Frames, FrameView
from knotfem.contact.material_points import material_room
from knotfem.contact.mobilisation import friction_limit, mobilisation_energy, mobilised, slip_stiffness
from knotfem.contact.pairs import PairContact
from knotfem.contact.samples import SampleView
from knotfem.contact.slip import SlipView, cut_slip, slip_view, traction_of
from knotfem.contact.spread import spread_on_arm
from knotfem.contact.surface import PairView
from knotfem.sparse.scatter import MatrixView, add_blocks


@kernel
def _assemble(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    friction: SlipView, residual: np.ndarray, matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of the friction of all pairs. False where a block lies outside the pattern."""
    points, pairs = contact
    room = pair_slip_room()
    T, arm = np.empty(3), np.empty(3)
    GP, GA = room.forces[0], room.forces[1]
    rows, columns = np.empty(6, np.int64), np.empty(9, np.int64)
    for k in range(pairs.sample.size):
        s: int = pairs.sample[k]
        friction.slip[k] = 0.0
        for i in range(3):
            friction.traction[k, i] = 0.0
        limit, slope = friction_limit(pairs.gap[k], pairs.law, friction.mu[k], samples.measure[s] * pairs.weight[k])
        if limit == 0.0:
            continue
        size, h, ahead = pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
        friction.slip[k] = room.slip.size[0]
        own, anchor = friction.own[k], friction.anchor[k]
        base: int = samples.nodes[s, 0]
        traction_of(room.slip, limit, friction.stick, T)
        rod: int = pairs.rod[k]
        between, lies = samples.between[s], between_middles(friction.u[k], ahead - curves.first[rod])
        part = samples.offset[s] / (samples.offset[s] + curves.radius[rod])
        touching_arms(x, points[s], ahead, part, room)
        arm_gradient(base, between, samples.weights[s], frames, room.arms[0], room.own, GP)
        arm_gradient(ahead, lies, room.w[0], frames, room.arms[1], room.other, GA)
        for i in range(3):
            friction.traction[k, i] = -T[i]
            rows[i] = columns[i] = base + i
            columns[3 + i] = room.pair.nodes[3 + i]
            rows[3 + i] = columns[6 + i] = ahead + i
        spread_on_arm(residual, base, GP, 1.0, T)
        spread_on_arm(residual, ahead, GA, -1.0, T)
        if not matrix.wanted:
            continue
        slip_stiffness(room.slip.e, limit, friction.stick, room.slip.M)
        law = friction.stick, -slope
        material.material_arm(own[1], own[2], room.own, arm)
        arm_gradient(base, between, samples.weights[s], frames, arm, room.own, room.slips[0])
        material.material_arm(anchor[1], anchor[2], room.other, arm)
        arm_gradient(ahead, lies, room.w[0], frames, arm, room.other, room.slips[1])
        pair_tangent(room, samples.rates[s], friction.stored[k], (size, h), law)
        add_arms(frames, (base, between, ahead, lies), (size, h, part), room, T)
        if not add_blocks(matrix, rows, columns, room.block):
            return False
    return True


@kernel
def _potential(
    x: np.ndarray, frames: FrameView, curves: CurveView, samples: SampleView, contact: tuple[np.ndarray, PairView],
    friction: SlipView,
) -> float:  # fmt: skip
    """Friction potential with the normal forces last assembled."""
    points, pairs = contact
    room = pair_slip_room()
    total = 0.0
    for k in range(pairs.sample.size):
        limit = friction.mu[k] * pairs.force[k]
        if limit == 0.0:
            continue
        pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
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
    room = pair_slip_room()
    for k in range(pairs.sample.size):
        if friction.mu[k] * pairs.force[k] == 0.0:
            friction.stored[k, 0] = friction.stored[k, 1] = 0.0
            continue
        pair_slip(x, frames, curves, samples, points, (pairs, k), friction, room)
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
        return slip_view(mu, rows, self.stick)

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
