"""Threads that computations take."""

from __future__ import annotations

import os

from knotfem.scene.model import Scene

MKL, OPENMP = "MKL_NUM_THREADS", "OMP_NUM_THREADS"
VARIABLES = (OPENMP, "OPENBLAS_NUM_THREADS", MKL, "NUMBA_NUM_THREADS")
"""Environment variables that tell libraries how many threads to take."""


def usable_threads() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def default_threads() -> int:
    """Threads of a solver that is not told how many: of the processors, no more than MKL or OpenMP are told to take."""
    for name in (MKL, OPENMP):
        told = os.environ.get(name, "").partition(",")[0].strip()
        if told.isdecimal() and int(told) > 0:
            return min(int(told), usable_threads())
    return usable_threads()


def threads_of(scene: Scene) -> int:
    """Threads of a scene's linear solver: as it asks, else one for discrete rods, whose systems are small, or all."""
    return scene.solver.threads or (1 if scene.model == "rod" else default_threads())
