"""Linear truss core on the axis nodes, its axial force an unknown of its own.

With g = l/h - 1 - N/EA and n the edge's direction, the force N is carried through the Newton iteration,
N += EA (g + n . (du_2 - du_1)/h), so that a sideways move of a stiff core is not taken for a stretch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel
from knotfem.solver.term import Arrays, Term
from knotfem.sparse.pattern import Matrix, add_blocks, element_keys

MERIT_AXIAL_STIFFNESS = 50.0
"""Moderate axial stiffness [N] of the line search's merit; the true one rejects every rotation."""


@kernel
def _assemble(x, edges, h, stiffness, force, residual, tangent, data, node_ptr, node_adj, upper):
    block = np.empty((6, 6))
    for k in range(edges.shape[0]):
        i, j = edges[k]
        d = x[j] - x[i]
        length = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        n = d / length
        condensed = stiffness * (length / h - 1.0)
        for c in range(3):
            residual[i, c] -= condensed * n[c]
            residual[j, c] += condensed * n[c]
        if tangent:
            for r in range(3):
                for c in range(3):
                    value = (stiffness / h - force[k] / length) * n[r] * n[c]
                    if r == c:
                        value += force[k] / length
                    block[r, c] = value
                    block[r + 3, c + 3] = value
                    block[r, c + 3] = -value
                    block[r + 3, c] = -value
            add_blocks(edges[k], block, node_ptr, node_adj, upper, data)


@dataclass
class Core(Term):
    """Truss of one rod, energy N^2 h / (2 EA) an edge.

    Args:
        edges: axis nodes of each edge, shape [slices, 2].
        edge_length: reference length h [mm].
        axial_stiffness: EA [N].
    """

    edges: np.ndarray
    edge_length: float
    axial_stiffness: float

    def __post_init__(self) -> None:
        self.name = "core"
        self.force = np.zeros(self.edges.shape[0])
        self._dforce = np.zeros_like(self.force)
        self._excess = np.zeros_like(self.force)
        self._direction = np.zeros((self.edges.shape[0], 3))

    def couplings(self, nodes: int) -> np.ndarray:
        return element_keys(self.edges, nodes)

    def strain(self, x: np.ndarray) -> np.ndarray:
        """Engineering strain of each edge."""
        return np.linalg.norm(x[self.edges[:, 1]] - x[self.edges[:, 0]], axis=1) / self.edge_length - 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        d = x[self.edges[:, 1]] - x[self.edges[:, 0]]
        length = np.linalg.norm(d, axis=1)
        self._direction = d / length[:, None]
        self._excess = self.axial_stiffness * (length / self.edge_length - 1.0) - self.force
        pattern = None if matrix is None else matrix.pattern
        _assemble(
            x,
            self.edges,
            self.edge_length,
            self.axial_stiffness,
            self.force,
            residual,
            matrix is not None,
            np.zeros(0) if matrix is None else matrix.data,
            _NONE if pattern is None else pattern.node_ptr,
            _NONE if pattern is None else pattern.node_adj,
            pattern is not None and pattern.upper,
        )
        return True

    def increment(self, du: np.ndarray) -> None:
        opening = np.einsum("ki,ki->k", self._direction, du[self.edges[:, 1]] - du[self.edges[:, 0]])
        self._dforce = self._excess + self.axial_stiffness * opening / self.edge_length

    def advance(self, fraction: float) -> None:
        self.force += fraction * self._dforce

    def merit(self, x: np.ndarray) -> float:
        e = self.strain(x)
        modulus = min(MERIT_AXIAL_STIFFNESS, self.axial_stiffness)
        return self.edge_length * float(np.sum((self.force + self._dforce) * e + 0.5 * modulus * e * e))

    def energy(self, x: np.ndarray) -> float:
        return 0.5 * self.axial_stiffness * self.edge_length * float(np.sum(self.strain(x) ** 2))

    def history(self) -> Arrays:
        return {"force": self.force.copy()}

    def load(self, history: Arrays) -> None:
        self.force[:] = history["force"]


_NONE = np.zeros(0, dtype=np.int64)
