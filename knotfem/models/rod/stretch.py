"""Stretching of the edges, the axial force an unknown of its own.

Energy EA h/2 (l/h - 1)^2 an edge. The rod's EA is thousands of newtons (bulk and core) against B/r^2 of ten: carrying
the axial force N through the Newton iteration, with g = l/h - 1 - N/EA and N += EA (g + n . (du_2 - du_1)/h), keeps a
sideways move from being taken for a stretch (see `knotfem.models.solid.core`, whose scheme this is).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel
from knotfem.mesh.rod_layout import RodLayout
from knotfem.solver.term import Arrays, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import add_blocks, matrix_arguments, stencil_keys

MERIT_STIFFNESS_OVER_BENDING = 5.0
"""Axial stiffness of the line search's merit, in units of B/r^2; the true one rejects every rotation."""


@kernel
def _assemble(x, edges, h, stiffness, rest, force, residual, tangent, node_ptr, node_adj, data, excess, direction):
    block = np.zeros((8, 8))
    nodes = np.empty(2, np.int64)
    d = np.empty(3)
    for k in range(edges.size):
        i = edges[k]
        for c in range(3):
            d[c] = x[i + 1, c] - x[i, c]
        length = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        carried = stiffness[k] * (length / h[k] - 1.0 - rest[k])
        excess[k] = carried - force[k]
        for c in range(3):
            direction[k, c] = d[c] / length
            residual[i, c] -= carried * direction[k, c]
            residual[i + 1, c] += carried * direction[k, c]
        if not tangent:
            continue
        across = force[k] / length
        for r in range(3):
            for c in range(3):
                value = (stiffness[k] / h[k] - across) * direction[k, r] * direction[k, c]
                if r == c:
                    value += across
                block[r, c] = block[r + 4, c + 4] = value
                block[r, c + 4] = block[r + 4, c] = -value
        nodes[0], nodes[1] = i, i + 1
        if not add_blocks(nodes, nodes, block, node_ptr, node_adj, data):
            return False
    return True


@dataclass
class Stretch(Term):
    """Axial stiffness of all edges.

    Args:
        layout: of the rods.
        stiffness: EA of each rod [N], shape [rods].
        merit_stiffness: of the line search's merit [N], shape [rods].
    """

    layout: RodLayout
    stiffness: np.ndarray
    merit_stiffness: np.ndarray

    def __post_init__(self) -> None:
        self.name = "stretch"
        rod = self.layout.rod[self.layout.edges]
        self._h = self.layout.spacing[rod]
        self._stiffness = np.asarray(self.stiffness, dtype=float)[rod]
        self._moderate = np.minimum(self._stiffness, np.asarray(self.merit_stiffness, dtype=float)[rod])
        self.force = np.zeros(rod.size)
        self._rest = np.zeros(rod.size)
        self._dforce = np.zeros(rod.size)
        self._excess = np.zeros(rod.size)
        self._direction = np.zeros((rod.size, 3))

    def couplings(self, nodes: int) -> np.ndarray:
        edges = self.layout.edges
        return stencil_keys(np.stack([edges, edges + 1], axis=1), nodes)

    def strain(self, x: np.ndarray) -> np.ndarray:
        """Engineering strain of each edge, shape [edges]."""
        edges = self.layout.edges
        return np.linalg.norm(x[edges + 1, :3] - x[edges, :3], axis=1) / self._h - 1.0

    def tension(self, x: np.ndarray) -> np.ndarray:
        """Axial force of each edge [N], shape [edges]."""
        return self._stiffness * (self.strain(x) - self._rest)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        return _assemble(
            x, self.layout.edges, self._h, self._stiffness, self._rest, self.force, residual,
            *matrix_arguments(matrix), self._excess, self._direction,
        )  # fmt: skip

    def increment(self, du: np.ndarray) -> None:
        edges = self.layout.edges
        opening = np.einsum("ki,ki->k", self._direction, du[edges + 1, :3] - du[edges, :3])
        self._dforce = self._excess + self._stiffness * opening / self._h

    def advance(self, fraction: float) -> None:
        self.force += fraction * self._dforce

    def merit(self, x: np.ndarray) -> float:
        e = self.strain(x) - self._rest
        return float(np.sum(self._h * ((self.force + self._dforce) * e + 0.5 * self._moderate * e * e)))

    def energy(self, x: np.ndarray) -> float:
        return 0.5 * float(np.sum(self._h * self._stiffness * (self.strain(x) - self._rest) ** 2))

    def history(self) -> Arrays:
        return {"force": self.force.copy()}

    def load(self, history: Arrays) -> None:
        self.force[:] = history["force"]
