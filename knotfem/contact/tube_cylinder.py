"""A rigid cylinder, touched by the rods' smooth surfaces, with friction of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.contact import tube_cylinder_kernels as kernels
from knotfem.contact.penalty import Penalty
from knotfem.contact.tube import Samples, sample_points
from knotfem.solver.term import Arrays, Term
from knotfem.sparse.pattern import Matrix, Pattern

_NONE = np.zeros(0, dtype=np.int64)


def _matrix_arguments(matrix: Matrix | None):
    if matrix is None:
        return np.zeros(0), _NONE, _NONE, False
    p: Pattern = matrix.pattern
    return matrix.data, p.node_ptr, p.node_adj, p.upper


@dataclass
class Cylinder(Term):
    """Normal contact of all samples with a rigid cylinder.

    Args:
        samples: points of the rods' surfaces.
        law: penalty law.
        origin: a point on the axis [mm], shape [3].
        axis: unit vector, shape [3].
        radius: [mm].
        closing: most that a predicted move may bring a sample closer where it ends inside [mm].

    Attributes:
        touching: samples near the cylinder.
        force: normal force of each sample [N], shape [samples].
    """

    samples: Samples
    law: Penalty
    origin: np.ndarray
    axis: np.ndarray
    radius: float
    closing: float = np.inf
    touching: np.ndarray = field(default_factory=lambda: _NONE, init=False)

    def __post_init__(self) -> None:
        self.name = "cylinder"
        count = self.samples.u.size
        self.points = np.zeros((count, 3))
        self.force = np.zeros(count)
        self._gap = np.zeros(count)
        self.gap = np.zeros(0)
        self._near = 10.0 * self.law.ramp

    def couplings(self, nodes: int) -> np.ndarray | None:
        patches = np.unique(self.samples.nodes[self.touching], axis=0)
        return np.unique(patches[:, :, None] * nodes + patches[:, None, :]) if patches.size else None

    def update(self, x: np.ndarray) -> None:
        sample_points(x, self.samples.nodes, self.samples.weights, self.points)
        found = np.empty(self.samples.u.size, dtype=np.int64)
        count = kernels.gaps(self.points, self.origin, self.axis, self.radius, found, self._gap, self._near)
        self.touching = found[:count].copy()
        self.gap = self._gap[:count].copy()

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        points = np.empty_like(self.points)
        sample_points(x + dx, self.samples.nodes, self.samples.weights, points)
        there = self._all_gaps(points)
        inside = there < 0.0
        if not inside.any():
            return 1.0
        closing = float((np.maximum(self._all_gaps(self.points[inside]), 0.0) - there[inside]).max())
        return min(1.0, self.closing / closing)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        s = self.samples
        self.force[:] = 0.0
        return kernels.assemble(
            s.nodes, s.weights, s.area, self.points, self.touching, self.origin, self.axis, self.radius,
            self.law.stiffness, self.law.ramp, residual, matrix is not None, *_matrix_arguments(matrix), self.force,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        points = np.empty_like(self.points)
        sample_points(x, self.samples.nodes, self.samples.weights, points)
        return self._stored(points)

    def energy(self, x: np.ndarray) -> float:
        return self._stored(self.points)

    @property
    def penetration(self) -> float:
        """Deepest penetration [mm]."""
        return float(max(0.0, -self.gap.min())) if self.gap.size else 0.0

    def _all_gaps(self, points: np.ndarray) -> np.ndarray:
        gap, every = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
        kernels.gaps(points, self.origin, self.axis, self.radius, every, gap, np.inf)
        return gap

    def _stored(self, points: np.ndarray) -> float:
        return kernels.energies(
            points, self.samples.area, self.origin, self.axis, self.radius, self.law.stiffness, self.law.ramp
        )


@dataclass
class CylinderFriction(Term):
    """Coulomb friction on a cylinder, which must come before it in the list of effects.

    Args:
        cylinder: whose samples rub.
        coefficients: mu of each rod, shape [rods].

    Attributes:
        anchors: point of the cylinder that each sample clings to [mm], shape [samples, 3].
    """

    cylinder: Cylinder
    coefficients: np.ndarray

    def __post_init__(self) -> None:
        self.name = "cylinder friction"
        self.symmetric = False
        count = self.cylinder.samples.u.size
        self.anchors = np.zeros((count, 3))
        self.slip = np.zeros(count)
        self.traction = np.zeros((count, 3))
        self.mu = np.asarray(self.coefficients, dtype=float)[self.cylinder.samples.rod]
        self._anchored = False

    def update(self, x: np.ndarray) -> None:
        if not self._anchored:
            self.commit(x)
            self._anchored = True

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        c = self.cylinder
        s = c.samples
        return kernels.assemble_friction(
            s.nodes, s.weights, s.area, c.points, c.touching, c.origin, c.axis, c.radius, c.law.stiffness, c.law.ramp,
            self.mu, c.law.stick, self.anchors, residual, matrix is not None, *_matrix_arguments(matrix),
            self.slip, self.traction,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        c = self.cylinder
        points = np.empty_like(c.points)
        sample_points(x, c.samples.nodes, c.samples.weights, points)
        return kernels.potential(points, c.touching, c.origin, c.axis, c.force, self.mu, c.law.stick, self.anchors)

    def commit(self, x: np.ndarray) -> None:
        c = self.cylinder
        kernels.drag_anchors(c.points, c.origin, c.axis, c.radius, c.force, self.slip, c.law.stick, self.anchors)

    def history(self) -> Arrays:
        return {"anchors": self.anchors.copy(), "anchored": np.array(self._anchored)}

    def load(self, history: Arrays) -> None:
        self.anchors[:] = history["anchors"]
        self._anchored = bool(history["anchored"])

    @property
    def sliding(self) -> int:
        """Number of samples beyond the stick distance."""
        return int(np.count_nonzero(self.slip[self.cylinder.touching] > self.cylinder.law.stick))
