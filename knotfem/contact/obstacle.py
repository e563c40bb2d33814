"""Normal contact of the samples of all rods with a rigid surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.law import Penalty, penalty
from knotfem.contact.rigid import Cylinder, RigidSurface
from knotfem.contact.samples import Samples, SampleView, sample_points
from knotfem.contact.spread import spread_force
from knotfem.contact.surface import Surface
from knotfem.solver.term import Role, Term
from knotfem.sparse.pattern import Matrix, stencil_keys, view_of
from knotfem.sparse.scatter import MatrixView, add_blocks

NEAR_OVER_RAMP = 10.0
"""Samples nearer to an obstacle than this, in ramps of the normal law, are looked at."""


class TouchView(NamedTuple):
    """Samples near an obstacle.

    Attributes:
        sample: shape [n].
        gap: [mm], shape [n].
        normal: shape [n, 3].
        turn: derivative of the normal by the point [1/mm], shape [n, 3, 3].
        force: normal force of every sample [N], shape [samples].
        law: normal law.
    """

    sample: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    turn: np.ndarray
    force: np.ndarray
    law: Penalty


@kernel
def add_sample_block(samples: SampleView, s: int, part: np.ndarray, matrix: MatrixView, block: np.ndarray) -> bool:
    """Add w_a w_b part (3, 3) of a sample's nodes to the matrix; `block` is work space of all its unknowns."""
    width, count = len(matrix.components), samples.nodes.shape[1]
    for a in range(count):
        for b in range(count):
            weight = samples.weights[s, a] * samples.weights[s, b]
            for i in range(3):
                for j in range(3):
                    block[width * a + i, width * b + j] = weight * part[i, j]
    return add_blocks(matrix, samples.nodes[s], samples.nodes[s], block)


@kernel
def _assemble(samples: SampleView, touch: TouchView, residual: np.ndarray, matrix: MatrixView) -> bool:
    """Residual and tangent of the samples near an obstacle, whose `force` is filled. False outside the pattern."""
    width, count = len(matrix.components), samples.nodes.shape[1]
    part, block = np.empty((3, 3)), np.zeros((width * count, width * count))
    for k in range(touch.sample.size):
        s: int = touch.sample[k]
        _, pressure, slope = penalty(touch.gap[k], touch.law)
        measure, n = samples.measure[s], touch.normal[k]
        touch.force[s] = measure * pressure
        if pressure == 0.0:
            continue
        spread_force(residual, samples.nodes[s], samples.weights[s], -touch.force[s], n)
        if not matrix.wanted:
            continue
        for i in range(3):
            for j in range(3):
                part[i, j] = measure * (slope * n[i] * n[j] - pressure * touch.turn[k, i, j])
        if not add_sample_block(samples, s, part, matrix, block):
            return False
    return True


@kernel
def _energy(measure: np.ndarray, gap: np.ndarray, law: Penalty) -> float:
    total = 0.0
    for s in range(gap.size):
        total += measure[s] * penalty(gap[s], law)[0]
    return total


class ObstacleContact(Term):
    """Normal contact of all rods with a rigid surface.

    Of a discrete rod and an obstacle only the rod gives way, so that a line stiffness of twice the one between two rods
    goes with Hertz's law.

    Args:
        surface: of all rods.
        samples: of it.
        law: normal law.
        obstacle: rigid.
        number: of the obstacle, from 1 on; 0 where there is one.

    Attributes:
        touch: samples near the obstacle.
        points: places of all samples [mm], shape [samples, 3].
        generation, match: for friction; the samples stay the same, each one a contact.
    """

    role, external = Role.CONTACT, True
    generation = 0

    def __init__(
        self, surface: Surface, samples: Samples, law: Penalty, obstacle: RigidSurface, number: int = 0
    ) -> None:
        self.name, self.number = "cylinder" if isinstance(obstacle, Cylinder) else "obstacle", number
        self.surface, self.samples, self.law, self.obstacle = surface, samples, law, obstacle
        self.points = np.zeros((samples.count, 3))
        self.match = np.full(samples.count, -1)
        self._closing = surface.limits.closing * float(surface.stations.radius.min())
        self._force = np.zeros(samples.count)
        self._near = NEAR_OVER_RAMP * law.ramp
        self._gap = np.zeros(samples.count)
        self.touch = self._view(np.zeros(0, dtype=np.int64))

    def describe(self) -> str:
        said = getattr(self.obstacle, "describe", None)
        return str(said()) if said else type(self.obstacle).__name__

    def couplings(self, nodes: int) -> np.ndarray | None:
        stencils = np.unique(self.samples.view.nodes[self.touch.sample], axis=0)
        return stencil_keys(stencils, nodes) if stencils.size else None

    def update(self, x: np.ndarray) -> None:
        sample_points(x, self.samples.view.nodes, self.samples.view.weights, self.points)
        self._gap = self._gaps(self.points)
        self.touch = self._view(np.flatnonzero(self._gap < self._near))

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        there = self._gaps(self.samples.places(x + dx))
        inside = there < 0.0
        if not inside.any():
            return 1.0
        closing = float((np.maximum(self._gap[inside], 0.0) - there[inside]).max())
        return min(1.0, self._closing / closing) if closing > 0.0 else 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        self._force[:] = 0.0
        return _assemble(self.samples.view, self.touch, residual, view_of(matrix, residual.shape[1]))

    def merit(self, x: np.ndarray) -> float:
        return self._stored(self._gaps(self.samples.places(x)))

    def energy(self, x: np.ndarray) -> float:
        return self._stored(self._gap)

    def coefficients(self, table: np.ndarray) -> np.ndarray:
        """Of each sample, shape [samples], from those of each rod, shape [rods]."""
        return table[self.samples.rod]

    @property
    def penetration(self) -> float:
        """Deepest penetration [mm]."""
        return float(max(0.0, -self.touch.gap.min(initial=0.0)))

    @property
    def touching(self) -> int:
        """Samples that carry force."""
        return int(np.count_nonzero(self._force))

    def _gaps(self, points: np.ndarray) -> np.ndarray:
        return self.obstacle.distance(points) - self.samples.view.offset

    def _stored(self, gap: np.ndarray) -> float:
        return _energy(self.samples.view.measure, gap, self.law)

    def _view(self, near: np.ndarray) -> TouchView:
        foot = self.obstacle.foot(self.points[near])
        return TouchView(near, self._gap[near], foot.normal, foot.turn, self._force, self.law)
