"""Condensation of the incompatible modes: elimination with pivots, on matrices of any kind."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from specimens import make_rod

from knotfem.models.solid.incompatible import condense_modes, eliminate


def random_matrix(seed: int, size: int) -> np.ndarray:
    """Indefinite, unsymmetric, of moderate condition, with a first entry of nearly zero."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.standard_normal((size, size)))
    r, _ = np.linalg.qr(rng.standard_normal((size, size)))
    matrix = q @ np.diag(rng.uniform(1.0, 10.0, size) * rng.choice([-1.0, 1.0], size)) @ r
    matrix[0] -= matrix[0, 0] / matrix[1, 0] * matrix[1]
    return matrix


@given(seed=st.integers(0, 10**6), size=st.integers(2, 9), columns=st.integers(1, 25))
@settings(max_examples=200, deadline=None)
def test_elimination_solves_as_numpy_does(seed, size, columns):
    matrix = random_matrix(seed, size)
    right = np.random.default_rng(seed + 1).standard_normal((size, columns))
    expected = np.linalg.solve(matrix, right)
    found = right.copy()
    pivot = eliminate(matrix.copy(), found)
    assert 0.0 < pivot <= 1.0
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.linalg.cond(matrix) * np.abs(expected).max())


@pytest.mark.parametrize("size", [1, 3, 9])
def test_a_singular_matrix_is_noticed(size):
    matrix = np.random.default_rng(0).standard_normal((size, size))
    matrix[-1] = 2.0 * matrix[0] if size > 1 else 0.0
    assert eliminate(matrix, np.ones((size, 2))) == 0.0
    assert eliminate(np.zeros((size, size)), np.ones((size, 2))) == 0.0


def blocks(count: int, extra: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Forces and a symmetric stiffness of nodes and modes, whose modes' block begins with a zero."""
    rng = np.random.default_rng(seed)
    whole = 3 * (count + extra)
    K = rng.standard_normal((whole, whole))
    K += K.T
    K[3 * count, 3 * count] = 0.0
    return rng.standard_normal(whole), K


@pytest.mark.parametrize("extra", [1, 2, 3])
def test_condensation_is_the_schur_complement_of_an_indefinite_matrix(extra):
    count = 8
    force, matrix = blocks(count, extra, seed=3)
    inner = slice(3 * count, None)
    outer = slice(None, 3 * count)
    expected_follow = np.linalg.solve(matrix[inner, inner], np.column_stack([matrix[inner, outer], force[inner]]))
    schur = matrix[outer, outer] - matrix[outer, inner] @ expected_follow[:, :-1]
    left = force[outer] - matrix[outer, inner] @ expected_follow[:, -1]

    f = np.ascontiguousarray(force.reshape(-1, 3).T)
    K = np.ascontiguousarray(matrix.reshape(count + extra, 3, count + extra, 3).transpose(1, 3, 0, 2))
    follow = np.empty((3 * extra, 3 * count + 1))
    assert condense_modes(f, K, np.empty((3 * extra, 3 * extra)), follow) > 0.0
    np.testing.assert_allclose(follow, expected_follow, atol=1e-11)
    np.testing.assert_allclose(f[:, :count].T.ravel(), left, atol=1e-10)
    found = K[:, :, :count, :count].transpose(2, 0, 3, 1).reshape(3 * count, 3 * count)
    np.testing.assert_allclose(found, schur, atol=1e-10)


def test_singular_modes_are_left_alone():
    count, extra = 8, 1
    force, matrix = blocks(count, extra, seed=4)
    matrix[-3:, -3:] = 0.0
    f = np.ascontiguousarray(force.reshape(-1, 3).T)
    K = np.ascontiguousarray(matrix.reshape(count + extra, 3, count + extra, 3).transpose(1, 3, 0, 2))
    before = K.copy()
    follow = np.empty((3, 3 * count + 1))
    assert condense_modes(f, K, np.empty((3, 3)), follow) == 0.0
    np.testing.assert_array_equal(K, before)
    assert not follow.any()


def test_a_state_with_singular_modes_is_not_admissible():
    rod = make_rod(6.0, 4, element="hex8-incompatible")
    x = rod.mesh.nodes
    rod.bulk.assemble(x, np.zeros_like(x), None)
    assert rod.bulk.admissible
    rod.bulk._view = rod.bulk._view._replace(modes=np.zeros_like(rod.bulk._view.modes))
    rod.bulk.assemble(x, np.zeros_like(x), None)
    assert not rod.bulk.admissible
