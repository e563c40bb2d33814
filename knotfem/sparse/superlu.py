"""SciPy's SuperLU behind the interface of all linear solvers."""

from __future__ import annotations

import numpy as np

from knotfem.sparse.base import SingularMatrixError, checked
from knotfem.sparse.pattern import Matrix, Pattern


class SuperLU:
    """SciPy's sparse LU; always there. It computes a new ordering at each factorisation."""

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
