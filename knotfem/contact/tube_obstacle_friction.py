"""Friction of tubes on a rigid surface, from anchors on it.

The obstacle has no unknowns of its own; all else is as between tubes. The derivative of the normal by the sample's
place is the Hessian of the distance.
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
from knotfem.contact.obstacle import ObstacleContact, TouchView, add_sample_block
from knotfem.contact.samples import SampleView
from knotfem.contact.spread import spread_force
from knotfem.geometry.rotation import across, dot
from knotfem.sparse.scatter import MatrixView


@kernel(error_model="numpy")
def _assemble(
    samples: SampleView, points: np.ndarray, touch: TouchView, friction: AnchorView, residual: np.ndarray,
    matrix: MatrixView,
) -> bool:  # fmt: skip
    """Residual and tangent of the friction of samples near an obstacle, from their anchors on it."""
    width, count = len(matrix.components), samples.nodes.shape[1]
    q, e = np.empty(3), np.empty(3)
    M, part, block = np.empty((3, 3)), np.empty((3, 3)), np.zeros((width * count, width * count))
    for k in range(touch.sample.size):
        s: int = touch.sample[k]
        n, dn = touch.normal[k], touch.turn[k]
        friction.slip[s] = 0.0
        friction.traction[s] = 0.0
        limit, slope = friction_limit(touch.gap[k], touch.law, friction.mu[s], samples.measure[s])
        if limit == 0.0:
            continue
        for i in range(3):
            q[i] = points[s, i] - friction.anchor[s, i]
        along, size = dot(n, q), across(n, q, e)
        friction.slip[s] = size
        psi_y = traction_at(e, size, -limit, friction.stick, friction.traction[s])
        spread_force(residual, samples.nodes[s], samples.weights[s], -1.0, friction.traction[s])
        if not matrix.wanted:
            continue
        slip_stiffness(e, limit, friction.stick, M)
        for i in range(3):
            lost = slope * psi_y / friction.stick * e[i]
            for j in range(3):
                qdn = q[0] * dn[0, j] + q[1] * dn[1, j] + q[2] * dn[2, j]
                value = -lost * n[j]
                for m in range(3):
                    de = (1.0 if m == j else 0.0) - n[m] * n[j] - along * dn[m, j] - n[m] * qdn
                    value += M[i, m] * de
                part[i, j] = value
        if not add_sample_block(samples, s, part, matrix, block):
            return False
    return True


@kernel
def _potential(points: np.ndarray, normal: np.ndarray, touch: TouchView, friction: AnchorView) -> float:
    q, total = np.empty(3), 0.0
    for k in range(touch.sample.size):
        s: int = touch.sample[k]
        if touch.force[s] == 0.0:
            continue
        for i in range(3):
            q[i] = points[s, i] - friction.anchor[s, i]
        size = np.sqrt(max(dot(q, q) - dot(normal[k], q) ** 2, 0.0))
        total += friction.mu[s] * touch.force[s] * friction.stick * mobilisation_energy(size / friction.stick)
    return total


@dataclass(frozen=True)
class TubeObstacleFriction:
    """Friction of tubes on a rigid surface; see `knotfem.contact.friction.FrictionLaw`.

    Attributes:
        stick: distance over which friction is mobilised [mm].
    """

    stick: float

    def fresh(self, contact: ObstacleContact, count: int) -> dict[str, np.ndarray]:
        """Anchors, points of the obstacle [mm]."""
        return {"anchor": np.zeros((count, 3))}

    def view(self, contact: ObstacleContact, mu: np.ndarray, rows: dict[str, np.ndarray]) -> AnchorView:
        """See the law."""
        return anchor_view(mu, rows, self.stick)

    def assemble(
        self, x: np.ndarray, contact: ObstacleContact, view: AnchorView, residual: np.ndarray, matrix: MatrixView
    ) -> bool:
        """See the law."""
        return _assemble(contact.samples.view, contact.points, contact.touch, view, residual, matrix)

    def potential(self, x: np.ndarray, contact: ObstacleContact, view: AnchorView) -> float:
        """See the law."""
        points = contact.samples.places(x)
        normal = contact.obstacle.foot(points[contact.touch.sample]).normal
        return _potential(points, normal, contact.touch, view)

    def commit(self, x: np.ndarray, contact: ObstacleContact, view: AnchorView) -> None:
        """Anchors of free samples go to the closest point, sliding ones follow at the stick distance."""
        foot = contact.obstacle.foot(contact.points)
        closest = contact.points - foot.distance[:, None] * foot.normal
        free = contact.touch.force == 0.0
        slides = ~free & (view.slip > self.stick)
        view.anchor[free] = closest[free]
        if slides.any():
            part = (self.stick / view.slip[slides])[:, None]
            moved = closest[slides] + part * (view.anchor[slides] - closest[slides])
            there = contact.obstacle.foot(moved)
            view.anchor[slides] = moved - there.distance[:, None] * there.normal

    def anchor(self, x: np.ndarray, contact: ObstacleContact, view: AnchorView, chosen: np.ndarray) -> None:
        """See the law."""
        points = contact.points[chosen]
        foot = contact.obstacle.foot(points)
        view.anchor[chosen] = points - foot.distance[:, None] * foot.normal

    def sliding(self, contact: ObstacleContact, view: AnchorView) -> np.ndarray:
        """Whether friction of each sample is fully mobilised, shape [samples]."""
        return mobilised(view.mu, view.traction, contact.touch.force)

    def stencils(self, contact: ObstacleContact, view: AnchorView) -> np.ndarray | None:
        """None beyond those of normal contact."""
        return None
