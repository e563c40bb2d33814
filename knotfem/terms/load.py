"""Forces on end sections, dead and following."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from knotfem.solver.term import StepStart, Term
from knotfem.sparse.pattern import Matrix, add_blocks

History = Callable[[float], float]
"""A scalar as a function of time [s]."""
VectorHistory = Callable[[float], np.ndarray]
"""A vector, shape [3], as a function of time [s]."""


@dataclass
class EndForce(Term):
    """A dead force on an end, shared among its nodes by `weights` (which sum to one).

    Args:
        nodes: shape [n].
        weights: shape [n].
        force: [N] as a function of time, shape [3].
    """

    nodes: np.ndarray
    weights: np.ndarray
    force: VectorHistory
    _now: np.ndarray = field(default_factory=lambda: np.zeros(3), init=False)

    def __post_init__(self) -> None:
        self.name = "load"

    def begin(self, start: StepStart) -> None:
        self._now = np.asarray(self.force(start.end), dtype=float)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[self.nodes, :3] -= self.weights[:, None] * self._now
        return True

    def merit(self, x: np.ndarray) -> float:
        return -float(self.weights @ (x[self.nodes, :3] @ self._now))


@dataclass
class FollowingForce(Term):
    """A force on a section along the end's tangent, from the axis node `inner` to the axis node `outer`.

    Weights need not sum to one: weights proportional to a section coordinate make an end moment.
    """

    nodes: np.ndarray
    weights: np.ndarray
    inner: int
    outer: int
    magnitude: History
    _force: float = field(default=0.0, init=False)
    _tangent: np.ndarray = field(default_factory=lambda: np.zeros(3), init=False)

    def __post_init__(self) -> None:
        self.name = "load"
        self.symmetric = False
        self._stencil = np.unique(np.concatenate([self.nodes, [self.inner, self.outer]])).astype(np.int64)

    def couplings(self, nodes: int) -> np.ndarray:
        keys = self._stencil[:, None] * nodes + self._stencil[None, :]
        return np.unique(keys)

    def begin(self, start: StepStart) -> None:
        self._force = self.magnitude(start.end)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        d = x[self.outer] - x[self.inner]
        length = float(np.linalg.norm(d))
        t = self._tangent = d / length
        residual[self.nodes] -= self._force * self.weights[:, None] * t
        if matrix is None:
            return True
        turn = -self._force / length * (np.eye(3) - np.outer(t, t))
        where = np.searchsorted(self._stencil, self.nodes)
        block = np.zeros((self._stencil.size, 3, self._stencil.size, 3))
        for sign, node in ((1.0, self.outer), (-1.0, self.inner)):
            column = int(np.searchsorted(self._stencil, node))
            block[where, :, column, :] += sign * self.weights[:, None, None] * turn
        pattern = matrix.pattern
        size = 3 * self._stencil.size
        return add_blocks(
            self._stencil, block.reshape(size, size), pattern.node_ptr, pattern.node_adj, pattern.upper, matrix.data
        )

    def merit(self, x: np.ndarray) -> float:
        """Of the force as a dead one along the tangent last assembled: a following force has no potential."""
        return -self._force * float(self.weights @ (x[self.nodes] @ self._tangent))
