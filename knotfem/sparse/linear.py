"""Direct linear solvers behind one small interface.

A solver is told of a new pattern by `analyse`, of new values by `factorise`, and then solves any number of right-hand
sides. `make_solver` knows them by name; an unknown name is an error.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from knotfem.errors import InputError, KnotfemError
from knotfem.sparse.pattern import Matrix, Pattern


class SingularMatrixError(KnotfemError):
    """The factorisation met a zero pivot or returned values that are not finite."""

    exit_code = 4


class LinearSolver(Protocol):
    """Analyse a pattern once, factorise its values, solve."""

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
        """Give memory back."""
        ...


class SuperLU:
    """SciPy's sparse LU; always there. It orders anew at each factorisation."""

    name = "superlu"

    def __init__(self) -> None:
        self._factors = None

    def analyse(self, pattern: Pattern) -> None:
        self._factors = None

    def factorise(self, matrix: Matrix) -> None:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        try:
            self._factors = splu(
                csc_array(matrix.to_scipy()),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SingularMatrixError(f"SuperLU: {error}") from error

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        assert self._factors is not None, "factorise before solve"
        return checked(self._factors.solve(rhs))

    def close(self) -> None:
        self._factors = None


def checked(solution: np.ndarray) -> np.ndarray:
    """The solution, or SingularMatrixError where it is not finite."""
    if not np.all(np.isfinite(solution)):
        raise SingularMatrixError("the linear solve returned values that are not finite")
    return solution


def available() -> list[str]:
    """Names of the solvers that work on this machine, best first."""
    from knotfem.sparse import pardiso

    return (["pardiso"] if pardiso.library() is not None else []) + ["superlu"]


def make_solver(name: str, threads: int = 0) -> LinearSolver:
    """A solver by name: "pardiso", "superlu", or "auto" for the best available.

    Args:
        name: which one.
        threads: 0 takes the library's own choice.
    """
    from knotfem.sparse import pardiso

    if name == "auto":
        name = available()[0]
    if name == "pardiso":
        return pardiso.Pardiso(threads)
    if name == "superlu":
        return SuperLU()
    raise InputError("unknown linear solver", key="solver.linear", found=name, expected="auto, pardiso or superlu")
