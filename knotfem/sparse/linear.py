"""Direct linear solvers by name; an unknown name is an error."""

from __future__ import annotations

from knotfem.errors import InputError
from knotfem.sparse import pardiso
from knotfem.sparse.base import LinearSolver


def available() -> list[str]:
    """Names of the solvers that work on this machine, best first."""
    return (["pardiso"] if pardiso.library() is not None else []) + ["superlu"]


def solver_name(name: str) -> str:
    """What a name stands for on this machine: "auto" for the best solver, any other for itself."""
    return available()[0] if name == "auto" else name


def make_solver(name: str, threads: int = 0) -> LinearSolver:
    """A solver by name: "pardiso", "superlu", or "auto" for the best available.

    Args:
        name: which one.
        threads: 0 takes the library's own choice.
    """
    name = solver_name(name)
    if name == "pardiso":
        return pardiso.Pardiso(threads)
    if name == "superlu":
        from knotfem.sparse.superlu import SuperLU

        return SuperLU()
    raise InputError("unknown linear solver", key="solver.linear", found=name, expected="auto, pardiso or superlu")
