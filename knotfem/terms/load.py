"""Forces on ends, dead and following."""

from __future__ import annotations

import numpy as np

from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.scatter import add_blocks
from knotfem.types import History, VectorHistory


class EndForce(Term):
    """A dead force on an end, distributed over its nodes.

    Args:
        nodes: shape [n].
        weights: fraction of the force on each node, shape [n], summing to one.
        force: [N], shape [3], as a function of time [s].
    """

    name, role, external = "load", Role.LOAD, True

    def __init__(self, nodes: np.ndarray, weights: np.ndarray, force: VectorHistory) -> None:
        self.nodes, self.weights, self.force = nodes, weights, force
        self._now = np.zeros(3)

    def begin(self, step: TimeStep) -> None:
        self._now = np.asarray(self.force(step.end), dtype=float)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[self.nodes, :3] -= self.weights[:, None] * self._now
        return True

    def merit(self, x: np.ndarray) -> float:
        return -float(self.weights @ (x[self.nodes, :3] @ self._now))


class FollowingForce(Term):
    """A force on an end along its tangent, from the axis node `inner` to the axis node `outer`.

    Weights need not sum to one: weights proportional to a section coordinate make an end moment.

    Args:
        nodes: that carry the force, shape [n].
        weights: fraction of the force on each, shape [n].
        inner: axis node beside the end.
        outer: axis node of the end.
        magnitude: positive outwards [N], as a function of time [s].
    """

    name, role, external, symmetric = "load", Role.LOAD, True, False

    def __init__(self, nodes: np.ndarray, weights: np.ndarray, inner: int, outer: int, magnitude: History) -> None:
        self.nodes, self.weights, self.magnitude = np.asarray(nodes, dtype=np.int64), weights, magnitude
        self.inner, self.outer = inner, outer
        self._force, self._tangent = 0.0, np.zeros(3)
        self._columns = np.array([inner, outer], dtype=np.int64)

    def couplings(self, nodes: int) -> np.ndarray:
        stencil = np.unique(np.concatenate([self.nodes, self._columns]))
        return np.unique(stencil[:, None] * nodes + stencil[None, :])

    def begin(self, step: TimeStep) -> None:
        self._force = self.magnitude(step.end)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        d = x[self.outer, :3] - x[self.inner, :3]
        length = float(np.linalg.norm(d))
        t = self._tangent = d / length
        residual[self.nodes, :3] -= self._force * self.weights[:, None] * t
        if matrix is None:
            return True
        turn = -self._force / length * (np.eye(3) - np.outer(t, t))
        width = residual.shape[1]
        block = np.zeros((self.nodes.size, width, 2, width))
        for column, sign in enumerate((-1.0, 1.0)):
            block[:, :3, column, :3] = sign * self.weights[:, None, None] * turn
        size = self.nodes.size
        return add_blocks(matrix.view, self.nodes, self._columns, block.reshape(size * width, 2 * width))

    def merit(self, x: np.ndarray) -> float:
        """Of the force as a dead one along the tangent last assembled: a following force has no potential."""
        return -self._force * float(self.weights @ (x[self.nodes, :3] @ self._tangent))
