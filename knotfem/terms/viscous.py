"""Viscous drag of a fluid at rest on the centreline, by resistive-force theory (Gray and Hancock 1955)."""

from __future__ import annotations

import numpy as np

from knotfem.geometry.vectors import unit_vectors
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.scatter import add_node_blocks


class ViscousDrag(Term):
    """Force -(c_n (1 - t t) + c_t t t) v for each unit of length, lumped at the axis nodes.

    The direction t of an edge is the one at the start of the step: the tangent stays symmetric, and the error is of
    first order in the step, like that of the velocity. For slender rods c_n is about twice c_t.

    Args:
        edges: axis nodes of each edge, shape [edges, 2].
        lengths: of the edges when free of stress [mm], shape [edges].
        normal: c_n, across the centreline [MPa s = N s/mm^2].
        tangential: c_t, along it [MPa s].
    """

    name, role, external = "viscous_drag", Role.RESISTANCE, True

    def __init__(self, edges: np.ndarray, lengths: np.ndarray, normal: float, tangential: float) -> None:
        self.edges, self.lengths = edges, lengths
        self.normal, self.tangential = normal, tangential
        self.nodes = np.unique(edges)
        self._ends = np.searchsorted(self.nodes, edges)
        self._resistance = np.zeros((self.nodes.size, 3, 3))
        self._step: TimeStep | None = None

    def describe(self) -> str:
        return f"{self.normal:g} MPa s across, {self.tangential:g} MPa s along"

    def begin(self, step: TimeStep) -> None:
        self._step = step
        x = step.start.x[:, :3]
        t = unit_vectors(x[self.edges[:, 1]] - x[self.edges[:, 0]])
        along = np.einsum("ki,kj->kij", t, t)
        half = 0.5 * self.lengths[:, None, None]
        weighted = half * (self.normal * np.eye(3) + (self.tangential - self.normal) * along)
        self._resistance[:] = 0.0
        for end in (0, 1):
            np.add.at(self._resistance, self._ends[:, end], weighted)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[self.nodes, :3] += np.einsum("nij,nj->ni", self._resistance, self._velocity(x))
        if matrix is None:
            return True
        return add_node_blocks(matrix.view, self.nodes, self._rate * self._resistance)

    def merit(self, x: np.ndarray) -> float:
        v = self._velocity(x)
        return 0.5 / self._rate * float(np.einsum("ni,nij,nj->", v, self._resistance, v))

    @property
    def _rate(self) -> float:
        assert self._step is not None, "begin before assemble"
        return self._step.velocity_rate

    def _velocity(self, x: np.ndarray) -> np.ndarray:
        assert self._step is not None, "begin before assemble"
        return self._step.velocity(x)[self.nodes, :3]
