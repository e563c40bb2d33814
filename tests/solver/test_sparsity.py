import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.sparse.pattern import Matrix, Pattern, add_blocks, element_keys, merge_keys

NODES = 7
ELEMENTS = np.array([[0, 3, 5], [5, 1, 3], [2, 6, 0], [4, 4, 4]])


def keys(elements: np.ndarray) -> np.ndarray:
    return merge_keys(np.arange(NODES) * (NODES + 1), element_keys(elements, NODES))


def filled(elements: np.ndarray, upper: bool, seed: int = 0) -> tuple[Matrix, np.ndarray]:
    """The same symmetric blocks in a sparse and in a dense matrix."""
    rng = np.random.default_rng(seed)
    matrix = Matrix(Pattern.from_keys(keys(elements), NODES, upper))
    dense = np.zeros((NODES, 3, NODES, 3))
    for nodes in elements:
        nodes = np.unique(nodes)
        size = 3 * nodes.size
        block = rng.standard_normal((size, size))
        block = block + block.T
        p = matrix.pattern
        assert add_blocks(nodes, block, p.node_ptr, p.node_adj, upper, matrix.data)
        dense[np.ix_(nodes, range(3), nodes, range(3))] += block.reshape(nodes.size, 3, nodes.size, 3)
    return matrix, dense.reshape(3 * NODES, 3 * NODES)


@settings(deadline=None, max_examples=30)
@given(
    st.lists(st.lists(st.integers(0, NODES - 1), min_size=3, max_size=3), min_size=1, max_size=6),
    st.booleans(),
    st.integers(0, 100),
)
def test_equals_the_dense_matrix(elements, upper, seed):
    matrix, dense = filled(np.array(elements), upper, seed)
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)
    x = np.random.default_rng(seed).standard_normal(3 * NODES)
    np.testing.assert_allclose(matrix.multiply(x), dense @ x, atol=1e-12)


@pytest.mark.parametrize("upper", [False, True])
def test_rows_are_sorted_and_hold_the_diagonal(upper):
    pattern = Pattern.from_keys(keys(ELEMENTS), NODES, upper)
    indptr, indices = pattern.csr
    assert indptr[-1] == indices.size
    for row in range(pattern.size):
        columns = indices[indptr[row] : indptr[row + 1]]
        assert (np.diff(columns) > 0).all()
        assert row in columns
        assert not upper or columns[0] == row


@pytest.mark.parametrize("upper", [False, True])
def test_diagonal_and_constraints(upper):
    matrix, dense = filled(ELEMENTS, upper)
    values = np.arange(1.0, 3 * NODES + 1)
    matrix.add_diagonal(values)
    dense[np.diag_indices(3 * NODES)] += values
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)
    fixed = np.zeros(3 * NODES, dtype=bool)
    fixed[[0, 4, 9, 20]] = True
    matrix.constrain(fixed, 2.5)
    dense[fixed], dense[:, fixed] = 0.0, 0.0
    dense[fixed, fixed] = 2.5
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)


def test_a_block_outside_the_pattern_is_reported():
    matrix, _ = filled(ELEMENTS, False)
    p = matrix.pattern
    assert not add_blocks(np.array([1, 6]), np.ones((6, 6)), p.node_ptr, p.node_adj, False, matrix.data)


def test_clearing_keeps_the_pattern():
    matrix, _ = filled(ELEMENTS, True)
    size = matrix.data.size
    matrix.clear()
    assert matrix.data.size == size
    assert not matrix.data.any()
