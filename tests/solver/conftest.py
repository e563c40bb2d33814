"""Effects so small that their solutions are known by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from knotfem.solver.term import Arrays, StepStart, Term
from knotfem.sparse.pattern import Matrix, add_blocks


@dataclass
class Spring(Term):
    """Each node hangs on the origin: force k x + c |x|^2 x, with a count of accepted steps as its history."""

    stiffness: float
    cubic: float = 0.0

    def __post_init__(self) -> None:
        self.name = "spring"
        self.accepted = np.zeros(1)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        square = np.einsum("ni,ni->n", x, x)
        residual += self.stiffness * x + self.cubic * square[:, None] * x
        if matrix is not None:
            p = matrix.pattern
            for node in range(len(x)):
                block = (self.stiffness + self.cubic * square[node]) * np.eye(3)
                block += 2.0 * self.cubic * np.outer(x[node], x[node])
                add_blocks(np.array([node]), block, p.node_ptr, p.node_adj, p.upper, matrix.data)
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
        self.accepted[:] = history["accepted"]


@dataclass
class Push(Term):
    """A force on the first node that may depend on time; it spoils its memory at once and may refuse steps."""

    force: Callable[[float], np.ndarray]
    refuses: Callable[[StepStart], bool] = lambda start: False
    begun: list[float] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self.name = "push"
        self.scratch = np.zeros(3)
        self._now, self._refused = np.zeros(3), False

    def begin(self, start: StepStart) -> None:
        self._now, self._refused = self.force(start.end), self.refuses(start)
        self.begun.append(start.dt)
        self.scratch += 1.0

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[0] -= np.nan if self._refused else self._now
        return True

    def merit(self, x: np.ndarray) -> float:
        return -float(x[0] @ self._now)

    def history(self) -> Arrays:
        return {"scratch": self.scratch.copy()}

    def load(self, history: Arrays) -> None:
        self.scratch[:] = history["scratch"]


@pytest.fixture
def spring():
    return Spring


@pytest.fixture
def push():
    return Push
