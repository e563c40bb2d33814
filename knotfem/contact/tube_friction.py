"""Coulomb friction between tubes by return mapping of stored anchors.

The stick distance is the constant, not a stiffness: a constant stiffness would be infinitely stiff at light load.
Nothing creeps: an anchor moves only when its pair slides, and only on an accepted step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from knotfem.contact import tube_friction_kernels as kernels
from knotfem.contact.tube import sample_points
from knotfem.contact.tube_contact import PATTERN_PAD, Contact
from knotfem.solver.term import Arrays, StepStart, Term
from knotfem.sparse.pattern import Matrix


@dataclass
class Friction(Term):
    """Friction of all pairs of a contact, which must come before it in the list of effects.

    Args:
        contact: whose pairs rub.
        coefficients: mu of each pair of rods, shape [rods, rods].
        factor: multiplies all coefficients, as a function of time [s]; None for 1.

    Attributes:
        anchors: parameters of the anchor of each pair, shape [pairs, 2].
        slip: distance from the anchor of each pair in contact [mm], shape [pairs].
        traction: friction force on the slave of each pair [N], shape [pairs, 3].
    """

    contact: Contact
    coefficients: np.ndarray
    factor: Callable[[float], float] | None = None
    anchors: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)), init=False)

    def __post_init__(self) -> None:
        self.name = "friction"
        self.symmetric = False
        self._generation = -1
        self._now = 1.0
        self.slip = np.zeros(0)
        self.traction = np.zeros((0, 3))
        self.mu = np.zeros(0)

    def couplings(self, nodes: int) -> np.ndarray | None:
        c = self.contact
        out = np.empty((c.pairs.shape[0], 36), dtype=np.int64)
        count = kernels.stray_stencils(
            c.tubes.arrays, c.samples.nodes, c.pairs, c.uv, c.gap, c.reach, PATTERN_PAD, self.anchors, out
        )
        out = np.unique(out[:count], axis=0)
        return np.unique(out[:, :, None] * nodes + out[:, None, :]) if count else None

    def begin(self, start: StepStart) -> None:
        if self.factor is not None:
            self._now = self.factor(start.end)
            self._size()

    def update(self, x: np.ndarray) -> None:
        c = self.contact
        if self._generation == c.generation:
            return
        anchors = c.uv.copy()
        if self.anchors.shape[0]:
            known = c.match >= 0
            anchors[known] = self.anchors[c.match[known]]
        self.anchors = anchors
        self._generation = c.generation
        self._size()

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        c, none = self.contact, np.zeros(0, dtype=np.int64)
        s = c.samples
        return kernels.assemble(
            x, c.tubes.arrays, s.nodes, s.weights, c.area, c.points, c.pairs, c.uv, c.gap, c.share, self.mu,
            c.law.stiffness, c.law.ramp, c.law.stick, self.anchors, residual, matrix is not None,
            np.zeros(0) if matrix is None else matrix.data,
            none if matrix is None else matrix.pattern.node_ptr,
            none if matrix is None else matrix.pattern.node_adj,
            matrix is not None and matrix.pattern.upper, self.slip, self.traction,
        )  # fmt: skip

    def merit(self, x: np.ndarray) -> float:
        c = self.contact
        points = np.empty_like(c.points)
        sample_points(x, c.samples.nodes, c.samples.weights, points)
        return kernels.potential(x, c.tubes.arrays, points, c.pairs, c.uv, c.force, self.mu, c.law.stick, self.anchors)

    def commit(self, x: np.ndarray) -> None:
        c = self.contact
        rubbing = np.where(self.mu > 0.0, c.force, 0.0)
        kernels.drag_anchors(c.uv, rubbing, self.slip, c.law.stick, c.tubes.around, c.pairs, self.anchors)

    def history(self) -> Arrays:
        return {"anchors": self.anchors.copy(), "now": np.array(self._now)}

    def load(self, history: Arrays) -> None:
        self.anchors, self._now = history["anchors"].copy(), float(history.get("now", 1.0))
        self._size()
        self._generation = self.contact.generation

    @property
    def sliding(self) -> int:
        """Number of pairs beyond the stick distance."""
        return int(np.count_nonzero(self.slip > self.contact.law.stick))

    def _size(self) -> None:
        c = self.contact
        self.slip = np.zeros(c.pairs.shape[0])
        self.traction = np.zeros((c.pairs.shape[0], 3))
        slaves = c.samples.rod[c.pairs[:, 0]]
        self.mu = self._now * self.coefficients[slaves, c.pairs[:, 1]]
