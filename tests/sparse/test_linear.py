import gc
import sys

import numpy as np
import pytest
from specimens import make_rod

from knotfem.errors import InputError, MissingDependency
from knotfem.sparse import pardiso
from knotfem.sparse.base import SingularMatrixError, checked
from knotfem.sparse.linear import available, make_solver
from knotfem.sparse.pattern import Matrix, Pattern


def rod_matrix(upper: bool, fixed: bool = True) -> Matrix:
    rod = make_rod(9.0, 6, section=20)
    pattern = Pattern.from_keys(rod.bulk.couplings(len(rod.mesh.nodes)), len(rod.mesh.nodes), upper)
    matrix = Matrix(pattern)
    rod.bulk.allocate(pattern)
    rod.bulk.assemble(rod.mesh.nodes, np.zeros_like(rod.mesh.nodes), matrix)
    clamped = np.zeros((len(rod.mesh.nodes), 3), dtype=bool)
    clamped[rod.sections[0]] = fixed
    matrix.constrain(clamped.ravel())
    return matrix


def test_missing_library_is_one_message(monkeypatch):
    stray = []
    monkeypatch.setattr(sys, "unraisablehook", stray.append)
    monkeypatch.setattr(pardiso, "library", lambda: None)
    with pytest.raises(MissingDependency, match="pip install mkl"):
        pardiso.Pardiso()
    gc.collect()
    assert not stray


@pytest.mark.parametrize("name", available())
@pytest.mark.parametrize("upper", [False, True])
def test_solves(name, upper):
    matrix = rod_matrix(upper)
    solver = make_solver(name)
    assert solver.name == name
    solver.analyse(matrix.pattern)
    exact = np.random.default_rng(0).standard_normal(matrix.pattern.size)
    rhs = matrix.multiply(exact)
    for scale in (1.0, 3.0):
        matrix.data *= scale
        solver.factorise(matrix)
        np.testing.assert_allclose(solver.solve(scale * rhs), exact, rtol=0, atol=1e-5)
        np.testing.assert_allclose(matrix.multiply(solver.solve(rhs)), rhs, atol=1e-9 * np.abs(rhs).max())
    solver.close()


@pytest.mark.parametrize("name", available())
@pytest.mark.parametrize("upper", [False, True])
def test_agrees_with_a_dense_solve(name, upper):
    matrix = rod_matrix(upper)
    rhs = np.random.default_rng(1).standard_normal(matrix.pattern.size)
    expected = np.linalg.solve(matrix.to_scipy().toarray(), rhs)
    solver = make_solver(name)
    solver.analyse(matrix.pattern)
    solver.factorise(matrix)
    np.testing.assert_allclose(solver.solve(rhs), expected, atol=1e-8 * np.abs(expected).max())
    solver.close()


@pytest.mark.parametrize("name", available())
def test_unsymmetric_values(name):
    matrix = rod_matrix(False)
    dense = matrix.to_scipy()
    rows = np.repeat(np.arange(matrix.pattern.size), np.diff(matrix.pattern.csr[0]))
    off = rows != matrix.pattern.csr[1]
    matrix.data[off] *= 1.0 + 0.01 * np.random.default_rng(0).standard_normal(np.count_nonzero(off))
    dense = matrix.to_scipy()
    assert abs(dense - dense.T).max() > 1e-3
    solver = make_solver(name)
    solver.analyse(matrix.pattern)
    solver.factorise(matrix)
    rhs = np.ones(matrix.pattern.size)
    np.testing.assert_allclose(dense @ solver.solve(rhs), rhs, atol=1e-8)


def solution_of(name: str, matrix: Matrix) -> np.ndarray:
    solver = make_solver(name)
    solver.analyse(matrix.pattern)
    solver.factorise(matrix)
    return solver.solve(np.ones(matrix.pattern.size))


@pytest.mark.parametrize("name", available())
def test_solutions_that_are_not_finite_are_refused(name):
    matrix = rod_matrix(False)
    matrix.data[matrix.pattern.csr[0][40]] = np.nan
    with pytest.raises(SingularMatrixError):
        solution_of(name, matrix)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_solutions_are_checked_in_one_place(value):
    good = np.array([1.0, -2.0])
    assert checked(good) is good
    with pytest.raises(SingularMatrixError, match="not finite"):
        checked(np.array([1.0, value]))


def test_superlu_refuses_a_singular_matrix():
    matrix = rod_matrix(False)
    matrix.data[:] = 0.0
    with pytest.raises(SingularMatrixError, match="SuperLU"):
        solution_of("superlu", matrix)


def test_unknown_names_are_refused():
    with pytest.raises(InputError, match=r"solver\.linear.*umfpack.*auto, pardiso or superlu"):
        make_solver("umfpack")


def test_auto_takes_the_best():
    assert make_solver("auto").name == available()[0]
    assert available()[-1] == "superlu"
