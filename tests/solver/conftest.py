"""Terms so small that their solutions are known by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.scatter import add_blocks
from knotfem.types import Arrays


@dataclass
class Spring(Term):
    """Each node hangs on the origin: force k x + c |x|^2 x; the sum of accepted x of the first node is its history."""

    stiffness: float
    cubic: float = 0.0
    name = "spring"
    role = Role.ELASTIC

    def __post_init__(self) -> None:
        self.accepted = np.zeros(1)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        square = np.einsum("ni,ni->n", x, x)
        residual += self.stiffness * x + self.cubic * square[:, None] * x
        if matrix is not None:
            for node in range(len(x)):
                block = (self.stiffness + self.cubic * square[node]) * np.eye(3)
                block += 2.0 * self.cubic * np.outer(x[node], x[node])
                add_blocks(matrix.view, np.array([node]), np.array([node]), block)
        return True

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)

    def energy(self, x: np.ndarray) -> float:
        square = np.einsum("ni,ni->n", x, x)
        return float(np.sum(0.5 * self.stiffness * square + 0.25 * self.cubic * square**2))

    def commit(self, x: np.ndarray) -> None:
        self.accepted += x[0, 0]

    def history(self) -> Arrays:
        return {"accepted": self.accepted.copy()}

    def load(self, history: Arrays) -> None:
        self.accepted[:] = history.get("accepted", 0.0)


@dataclass
class Push(Term):
    """A force on the first node that may depend on time; it changes its history at once and may refuse steps."""

    force: Callable[[float], np.ndarray]
    refuses: Callable[[TimeStep], bool] = lambda step: False
    begun: list[float] = field(default_factory=list, init=False)
    name = "push"

    def __post_init__(self) -> None:
        self.scratch = np.zeros(3)
        self._now, self._refused = np.zeros(3), False

    def begin(self, step: TimeStep) -> None:
        self._now, self._refused = self.force(step.end), self.refuses(step)
        self.begun.append(step.dt)
        self.scratch += 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[0] -= np.nan if self._refused else self._now
        return True

    def merit(self, x: np.ndarray) -> float:
        return -float(x[0] @ self._now)

    def history(self) -> Arrays:
        return {"scratch": self.scratch.copy()}

    def load(self, history: Arrays) -> None:
        self.scratch[:] = history.get("scratch", 0.0)


@pytest.fixture
def spring():
    return Spring


@pytest.fixture
def push():
    return Push
