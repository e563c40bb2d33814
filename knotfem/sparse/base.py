"""What every direct linear solver offers, and how one fails."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from knotfem.errors import KnotfemError
from knotfem.sparse.pattern import Matrix, Pattern


class SingularMatrixError(KnotfemError):
    """The factorisation met a zero pivot or returned values that are not finite."""

    exit_code = 4


class LinearSolver(Protocol):
    """Analyse a pattern once, factorise its values, solve for any number of right-hand sides."""

    name: str

    def analyse(self, pattern: Pattern) -> None:
        """Order and allocate for a pattern."""
        ...

    def factorise(self, matrix: Matrix) -> None:
        """Factorise the values; the pattern is that of the last analysis."""
        ...

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for one right-hand side, shape [unknowns]."""
        ...

    def close(self) -> None:
        """Release memory."""
        ...


def checked(solution: np.ndarray) -> np.ndarray:
    """The solution, or SingularMatrixError where it is not finite."""
    if not np.all(np.isfinite(solution)):
        raise SingularMatrixError("the linear solve returned values that are not finite")
    return solution
