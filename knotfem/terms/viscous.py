"""Viscous drag of a fluid at rest on the centreline, by resistive-force theory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.solver.term import Moving, StepStart
from knotfem.sparse.pattern import Matrix, add_node_blocks
from knotfem.terms.registry import Strand, quantity

_COEFFICIENT = ("a coefficient of resistance", "MPa s", "Pa s", "2 Pa s")


@dataclass(frozen=True)
class Settings:
    """Force per length over velocity; for slender rods the first is about twice the second (Gray and Hancock 1955).

    Attributes:
        normal: across the centreline [MPa s = N s/mm^2].
        tangential: along it [MPa s].
    """

    normal: float = quantity(*_COEFFICIENT, minimum=0.0)
    tangential: float = quantity(*_COEFFICIENT, minimum=0.0)


def absent(settings: Settings) -> str:
    """Why there is none; "" where there is."""
    return "" if settings.normal > 0.0 or settings.tangential > 0.0 else "both coefficients are 0"


def make(settings: Settings, rods: Sequence[Strand]) -> ViscousDrag:
    """The drag on all rods."""
    edges = [np.stack([rod.axis_nodes[:-1], rod.axis_nodes[1:]], axis=1) for rod in rods]
    lengths = [np.full(rod.axis_nodes.size - 1, rod.mesh.length / (rod.axis_nodes.size - 1)) for rod in rods]
    return ViscousDrag(np.concatenate(edges), np.concatenate(lengths), settings.normal, settings.tangential)


@dataclass
class ViscousDrag(Moving):
    """Force -(c_n (1 - t t) + c_t t t) v per length, lumped at the axis nodes.

    The direction t of an edge is the one at the start of the step: the tangent stays symmetric, and the error is of
    first order in the step, like that of the velocity.

    Args:
        edges: axis nodes of each edge, shape [edges, 2].
        lengths: of the edges when free of stress [mm], shape [edges].
        normal: c_n [MPa s].
        tangential: c_t [MPa s].
    """

    edges: np.ndarray
    lengths: np.ndarray
    normal: float
    tangential: float

    def __post_init__(self) -> None:
        self.name = "viscous_drag"
        self.viscous = True
        self.nodes = np.unique(self.edges)
        self._ends = np.searchsorted(self.nodes, self.edges)
        self._resistance = np.zeros((self.nodes.size, 3, 3))

    def begin(self, start: StepStart) -> None:
        super().begin(start)
        x = start.motion.x[:, :3]
        t = x[self.edges[:, 1]] - x[self.edges[:, 0]]
        t /= np.linalg.norm(t, axis=1)[:, None]
        along = np.einsum("ki,kj->kij", t, t)
        half = 0.5 * self.lengths[:, None, None]
        share = half * (self.normal * np.eye(3) + (self.tangential - self.normal) * along)
        self._resistance[:] = 0.0
        for end in (0, 1):
            np.add.at(self._resistance, self._ends[:, end], share)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[self.nodes, :3] += np.einsum("nij,nj->ni", self._resistance, self._velocity(x))
        if matrix is None:
            return True
        return self._add(self.scheme.velocity_rate(self.start.dt) * self._resistance, matrix)

    def merit(self, x: np.ndarray) -> float:
        v, rate = self._velocity(x), self.scheme.velocity_rate(self.start.dt)
        return 0.5 / rate * float(np.einsum("ni,nij,nj->", v, self._resistance, v))

    def _add(self, blocks: np.ndarray, matrix: Matrix) -> bool:
        p = matrix.pattern
        return add_node_blocks(self.nodes, blocks, p.node_ptr, p.node_adj, p.upper, matrix.data)

    def _velocity(self, x: np.ndarray) -> np.ndarray:
        return self.scheme.velocity(x, self.start)[self.nodes, :3]
