"""Axial stiffness of edges, the axial force an unknown of its own: the truss core of a solid, the stretch of a rod.

Energy EA h/2 (l/h - 1)^2 for each edge. The axial stiffness of a rod is thousands of newtons against B/r^2 of ten.
Carrying the axial force N through the Newton iteration, with g = l/h - 1 - N/EA, n the edge's direction, and
N += EA (g + n . (du_2 - du_1)/h), keeps a sideways move from being taken for a stretch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.rotation import unit
from knotfem.solver.term import Role, Term
from knotfem.sparse.pattern import Matrix, stencil_keys, view_of
from knotfem.sparse.scatter import MatrixView, add_blocks
from knotfem.types import Arrays


class EdgeView(NamedTuple):
    """Edges and their axial forces.

    Attributes:
        nodes: of each edge, shape [edges, 2].
        length: when free of stress [mm], shape [edges].
        stiffness: EA [N], shape [edges].
        rest: strain that is free of stress, shape [edges].
        force: axial force carried by the Newton iteration [N], shape [edges].
        excess: EA g, filled [N], shape [edges].
        direction: unit vector along each edge, filled, shape [edges, 3].
    """

    nodes: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    rest: np.ndarray
    force: np.ndarray
    excess: np.ndarray
    direction: np.ndarray


@kernel
def _assemble(x: np.ndarray, edges: EdgeView, residual: np.ndarray, matrix: MatrixView) -> bool:
    width = len(matrix.components)
    block = np.zeros((2 * width, 2 * width))
    for k in range(edges.length.size):
        i, j = edges.nodes[k]
        h, stiffness, direction = edges.length[k], edges.stiffness[k], edges.direction[k]
        for c in range(3):
            direction[c] = x[j, c] - x[i, c]
        length = unit(direction, direction)
        carried = stiffness * (length / h - 1.0 - edges.rest[k])
        edges.excess[k] = carried - edges.force[k]
        for c in range(3):
            residual[i, c] -= carried * direction[c]
            residual[j, c] += carried * direction[c]
        if not matrix.wanted:
            continue
        across = edges.force[k] / length
        for r in range(3):
            for c in range(3):
                value = (stiffness / h - across) * direction[r] * direction[c]
                if r == c:
                    value += across
                block[r, c] = block[r + width, c + width] = value
                block[r, c + width] = block[r + width, c] = -value
        if not add_blocks(matrix, edges.nodes[k], edges.nodes[k], block):
            return False
    return True


class AxialStiffness(Term):
    """Axial stiffness of edges.

    Args:
        name: "core" or "stretch".
        edges: nodes of each edge, shape [edges, 2].
        length: of each when free of stress [mm], shape [edges].
        stiffness: EA of each [N], shape [edges].
        merit_stiffness: moderate axial stiffness of the line search's merit [N], shape [edges]; the true one rejects
            every rotation.

    Attributes:
        view: edges and axial forces.
    """

    role = Role.ELASTIC

    def __init__(
        self,
        name: str,
        edges: np.ndarray,
        length: np.ndarray,
        stiffness: np.ndarray,
        merit_stiffness: np.ndarray,
    ) -> None:
        self.name = name
        count = len(edges)
        self.view = EdgeView(
            np.asarray(edges, dtype=np.int64),
            np.broadcast_to(np.asarray(length, dtype=float), count).copy(),
            np.broadcast_to(np.asarray(stiffness, dtype=float), count).copy(),
            np.zeros(count),
            np.zeros(count),
            np.zeros(count),
            np.zeros((count, 3)),
        )
        self.merit_stiffness = np.minimum(self.view.stiffness, merit_stiffness)
        self._dforce = np.zeros(count)

    def describe(self) -> str:
        return f"EA {', '.join(f'{value:.5g}' for value in np.unique(self.view.stiffness))} N"

    @property
    def force(self) -> np.ndarray:
        """Axial force of each edge [N], that of the Newton iteration, shape [edges]."""
        return self.view.force

    def couplings(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.view.nodes, nodes)

    def strain(self, x: np.ndarray) -> np.ndarray:
        """Engineering strain of each edge, shape [edges]."""
        first, second = self.view.nodes.T
        return np.linalg.norm(x[second, :3] - x[first, :3], axis=1) / self.view.length - 1.0

    def tension(self, x: np.ndarray) -> np.ndarray:
        """Axial force of each edge by its strain [N], shape [edges]."""
        return self.view.stiffness * (self.strain(x) - self.view.rest)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        return _assemble(x, self.view, residual, view_of(matrix, residual.shape[1]))

    def increment(self, du: np.ndarray) -> None:
        v, (first, second) = self.view, self.view.nodes.T
        opening = np.einsum("ki,ki->k", v.direction, du[second, :3] - du[first, :3])
        self._dforce = v.excess + v.stiffness * opening / v.length

    def advance(self, fraction: float) -> None:
        self.view.force[:] += fraction * self._dforce

    def merit(self, x: np.ndarray) -> float:
        e = self.strain(x) - self.view.rest
        return float(
            np.sum(self.view.length * ((self.view.force + self._dforce) * e + 0.5 * self.merit_stiffness * e * e))
        )

    def energy(self, x: np.ndarray) -> float:
        v = self.view
        return 0.5 * float(np.sum(v.length * v.stiffness * (self.strain(x) - v.rest) ** 2))

    def history(self) -> Arrays:
        return {"force": self.view.force.copy()}

    def load(self, history: Arrays) -> None:
        self.view.force[:] = history.get("force", 0.0)
