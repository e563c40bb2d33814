import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.sparse.pattern import Matrix, Pattern, merge_keys, stencil_keys, view_of
from knotfem.sparse.scatter import add_blocks, add_node_blocks

NODES = 7
ELEMENTS = np.array([[0, 3, 5], [5, 1, 3], [2, 6, 0], [4, 4, 4]])
WIDTHS = pytest.mark.parametrize("width", [3, 4])


def keys(elements: np.ndarray) -> np.ndarray:
    return merge_keys(np.arange(NODES) * (NODES + 1), stencil_keys(elements, NODES))


def filled(elements: np.ndarray, upper: bool, width: int, seed: int = 0) -> tuple[Matrix, np.ndarray]:
    """The same symmetric blocks in a sparse and in a dense matrix."""
    rng = np.random.default_rng(seed)
    matrix = Matrix(Pattern.from_keys(keys(elements), NODES, upper, width))
    dense = np.zeros((NODES, width, NODES, width))
    for nodes in elements:
        nodes = np.unique(nodes)
        size = width * nodes.size
        block = rng.standard_normal((size, size))
        block = block + block.T
        assert add_blocks(matrix.view, nodes, nodes, block)
        parts = np.arange(width)
        dense[np.ix_(nodes, parts, nodes, parts)] += block.reshape(nodes.size, width, nodes.size, width)
    return matrix, dense.reshape(width * NODES, width * NODES)


@settings(deadline=None, max_examples=30)
@given(
    st.lists(st.lists(st.integers(0, NODES - 1), min_size=3, max_size=3), min_size=1, max_size=6),
    st.booleans(),
    st.sampled_from([3, 4]),
    st.integers(0, 100),
)
def test_equals_the_dense_matrix(elements, upper, width, seed):
    matrix, dense = filled(np.array(elements), upper, width, seed)
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)
    x = np.random.default_rng(seed).standard_normal(width * NODES)
    np.testing.assert_allclose(matrix.multiply(x), dense @ x, atol=1e-12)


@WIDTHS
@pytest.mark.parametrize("upper", [False, True])
def test_rows_are_sorted_and_hold_the_diagonal(upper, width):
    pattern = Pattern.from_keys(keys(ELEMENTS), NODES, upper, width)
    indptr, indices = pattern.csr
    assert indptr[-1] == indices.size
    for row in range(pattern.size):
        columns = indices[indptr[row] : indptr[row + 1]]
        assert (np.diff(columns) > 0).all()
        assert row in columns
        assert not upper or columns[0] == row


@WIDTHS
@pytest.mark.parametrize("upper", [False, True])
def test_diagonal_and_constraints(upper, width):
    size = width * NODES
    matrix, dense = filled(ELEMENTS, upper, width)
    values = np.arange(1.0, size + 1)
    matrix.add_diagonal(values)
    dense[np.diag_indices(size)] += values
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)
    fixed = np.zeros(size, dtype=bool)
    fixed[[0, 4, 9, 20]] = True
    matrix.constrain(fixed)
    dense[fixed], dense[:, fixed] = 0.0, 0.0
    dense[fixed, fixed] = 1.0
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense, atol=1e-13)


@WIDTHS
def test_rows_and_columns_may_differ_and_negative_nodes_are_left_out(width):
    matrix = Matrix(Pattern.from_keys(keys(ELEMENTS), NODES, False, width))
    rows, columns = np.array([5, -1, 3]), np.array([0, 3, -1, 5])
    block = np.random.default_rng(2).standard_normal((3 * width, 4 * width))
    assert add_blocks(matrix.view, rows, columns, block)
    dense = np.zeros((NODES, width, NODES, width))
    parts = block.reshape(3, width, 4, width)
    for r, row in enumerate(rows):
        for c, column in enumerate(columns):
            if row >= 0 and column >= 0:
                dense[row, :, column] += parts[r, :, c]
    np.testing.assert_array_equal(matrix.to_scipy().toarray(), dense.reshape(width * NODES, -1))


@WIDTHS
@pytest.mark.parametrize("upper", [False, True])
def test_blocks_of_places_stand_on_the_diagonal(upper, width):
    matrix = Matrix(Pattern.from_keys(keys(ELEMENTS), NODES, upper, width))
    blocks = np.random.default_rng(1).standard_normal((2, 3, 3))
    blocks += blocks.transpose(0, 2, 1)
    nodes = np.array([6, 2])
    assert add_node_blocks(matrix.view, nodes, blocks)
    dense = np.zeros((NODES, width, NODES, width))
    for node, block in zip(nodes, blocks, strict=True):
        dense[node, :3, node, :3] = block
    np.testing.assert_allclose(matrix.to_scipy().toarray(), dense.reshape(width * NODES, -1), atol=1e-15)


@WIDTHS
def test_a_block_outside_the_pattern_is_reported(width):
    matrix, _ = filled(ELEMENTS, False, width)
    nodes = np.array([1, 6])
    assert not add_blocks(matrix.view, nodes, nodes, np.ones((2 * width, 2 * width)))


@WIDTHS
def test_clearing_keeps_the_pattern(width):
    matrix, _ = filled(ELEMENTS, True, width)
    size = matrix.data.size
    matrix.clear()
    assert matrix.data.size == size
    assert not matrix.data.any()


@WIDTHS
def test_a_view_says_whether_there_is_a_matrix(width):
    matrix, _ = filled(ELEMENTS, False, width)
    assert view_of(matrix, width).wanted
    assert view_of(matrix, width).data is matrix.data
    nothing = view_of(None, width)
    assert not nothing.wanted
    assert len(nothing.components) == len(matrix.view.components) == width


def test_keys_leave_out_negative_nodes_and_are_sorted_and_unique():
    found = stencil_keys(np.array([[3, -1, 0], [0, 3, -1]]), NODES)
    np.testing.assert_array_equal(found, [0, 3, 3 * NODES, 3 * NODES + 3])
    assert stencil_keys(np.zeros((0, 4), dtype=int), NODES).size == 0
    np.testing.assert_array_equal(merge_keys(np.array([5, 2]), np.array([2, 9])), [2, 5, 9])
