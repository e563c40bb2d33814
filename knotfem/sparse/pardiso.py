"""Intel MKL PARDISO through ctypes, the analysis kept while the pattern holds.

Parameter numbers are those of the oneMKL developer reference, "pardiso" (iparm, counted from 0 here).
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from importlib import metadata
from pathlib import Path

import numpy as np

from knotfem.errors import MissingDependency
from knotfem.sparse.base import SingularMatrixError, checked
from knotfem.sparse.pattern import Matrix, Pattern

_INDEFINITE, _UNSYMMETRIC = -2, 11
_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1


def _candidates() -> list[Path]:
    names = {"win32": "mkl_rt", "darwin": "libmkl_rt"}
    stem = names.get(sys.platform, "libmkl_rt.so")
    try:
        files = metadata.files("mkl") or []
    except metadata.PackageNotFoundError:
        return []
    return [Path(str(file.locate())) for file in files if file.name.startswith(stem)]


@cache
def library() -> ctypes.CDLL | None:
    """The MKL run-time library, or None where it is not installed."""
    for path in _candidates():
        try:
            return ctypes.CDLL(str(path))
        except OSError:
            continue
    return None


class Pardiso:
    """PARDISO for symmetric indefinite (upper patterns) and structurally symmetric systems."""

    name = "pardiso"

    def __init__(self, threads: int = 0) -> None:
        self._pattern: Pattern | None = None
        mkl = library()
        if mkl is None:
            raise MissingDependency("MKL PARDISO is not installed; cure: pip install mkl, or solver.linear = 'superlu'")
        self._pardiso = mkl.pardiso
        if threads > 0:
            mkl.MKL_Set_Num_Threads(ctypes.c_int(threads))
        self._handle = np.zeros(64, dtype=np.int64)
        self._values = np.zeros(1)

    def analyse(self, pattern: Pattern) -> None:
        self.close()
        self._pattern = pattern
        self._type = _INDEFINITE if pattern.upper else _UNSYMMETRIC
        iparm = np.zeros(64, dtype=np.int32)
        iparm[0] = 1  # take this array, not the defaults
        iparm[1] = 2  # nested dissection (METIS)
        iparm[7] = 0  # iterative refinement only after perturbed pivots
        iparm[9] = 8 if pattern.upper else 13  # pivot perturbation 10^-n
        iparm[10] = 0  # no scaling: the values are not known at the analysis
        iparm[12] = 0  # no matching, likewise
        iparm[20] = 1  # Bunch-Kaufman pivots
        iparm[23] = 1  # two-level factorisation
        iparm[34] = 1  # indices count from 0
        self._iparm = iparm
        self._call(_ANALYSE, np.zeros(pattern.csr[1].size))

    def factorise(self, matrix: Matrix) -> None:
        self._values = matrix.data.copy()
        self._call(_FACTORISE, self._values)

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        solution = np.empty_like(rhs)
        self._call(_SOLVE, self._values, np.ascontiguousarray(rhs), solution)
        return checked(solution)

    def close(self) -> None:
        if self._pattern is not None:
            self._call(_RELEASE, self._values)
            self._pattern = None
            self._handle[:] = 0

    def __del__(self) -> None:
        if not sys.is_finalizing():
            self.close()

    def _call(self, phase: int, values: np.ndarray, rhs: np.ndarray | None = None, out: np.ndarray | None = None):
        assert self._pattern is not None, "analyse before factorise"
        indptr, indices = self._pattern.csr
        unused = np.zeros(1)
        rhs = unused if rhs is None else rhs
        out = unused if out is None else out
        error = ctypes.c_int(0)

        def number(value: int):
            return ctypes.byref(ctypes.c_int(value))

        self._pardiso(
            self._handle.ctypes.data_as(ctypes.c_void_p),
            number(1),
            number(1),
            number(self._type),
            number(phase),
            number(self._pattern.size),
            values.ctypes.data_as(ctypes.c_void_p),
            indptr.ctypes.data_as(ctypes.c_void_p),
            indices.ctypes.data_as(ctypes.c_void_p),
            unused.ctypes.data_as(ctypes.c_void_p),
            number(1),
            self._iparm.ctypes.data_as(ctypes.c_void_p),
            number(0),
            rhs.ctypes.data_as(ctypes.c_void_p),
            out.ctypes.data_as(ctypes.c_void_p),
            ctypes.byref(error),
        )
        if error.value != 0:
            raise SingularMatrixError(f"PARDISO phase {phase} ended with error {error.value}")
