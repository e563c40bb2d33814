"""Sparsity of a system of four unknowns a node: three of place, one of spin.

The scalar CSR pattern consists of dense 4 x 4 node blocks; explicit zeros stay, as in `knotfem.sparse.pattern`, whose
`Matrix` it serves.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from knotfem.compiled import kernel
from knotfem.sparse.pattern import Matrix, Pattern, block_slot

NO_NODES = np.zeros(0, dtype=np.int64)


@kernel
def _expand(node_ptr, node_adj, indptr, indices):
    for a in range(node_ptr.size - 1):
        degree = node_ptr[a + 1] - node_ptr[a]
        for i in range(4):
            start = 16 * node_ptr[a] + 4 * degree * i
            indptr[4 * a + i] = start
            for k in range(degree):
                for j in range(4):
                    indices[start + 4 * k + j] = 4 * node_adj[node_ptr[a] + k] + j


@kernel(inline="always")
def add_block(a, b, block, row, column, node_ptr, node_adj, data):
    """Add block[row : row + 4, column : column + 4] to nodes (a, b). Returns False where that lies outside."""
    slot = block_slot(node_ptr, node_adj, a, b)
    if slot < 0:
        return False
    degree = node_ptr[a + 1] - node_ptr[a]
    for i in range(4):
        start = 16 * node_ptr[a] + 4 * degree * i + 4 * slot
        for j in range(4):
            data[start + j] += block[row + i, column + j]
    return True


@kernel
def add_blocks(rows, columns, block, node_ptr, node_adj, data):
    """Add a dense block, shape [4 rows, 4 columns], over nodes; negative nodes are left out.

    Returns:
        False when one lies outside the pattern.
    """
    for p in range(rows.size):
        if rows[p] < 0:
            continue
        for q in range(columns.size):
            if columns[q] < 0:
                continue
            if not add_block(rows[p], columns[q], block, 4 * p, 4 * q, node_ptr, node_adj, data):
                return False
    return True


class RodPattern(Pattern):
    """Sparsity over nodes with four unknowns each, both triangles stored."""

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return 4 * (self.node_ptr.size - 1)

    @cached_property
    def csr(self) -> tuple[np.ndarray, np.ndarray]:
        """Scalar (indptr, indices), both int32."""
        indptr = np.empty(self.size + 1, dtype=np.int32)
        indices = np.empty(16 * self.node_adj.size, dtype=np.int32)
        _expand(self.node_ptr, self.node_adj, indptr, indices)
        indptr[-1] = indices.size
        return indptr, indices


def matrix_arguments(matrix: Matrix | None) -> tuple[bool, np.ndarray, np.ndarray, np.ndarray]:
    """Whether a tangent is wanted, and its node_ptr, node_adj and values, for compiled loops."""
    if matrix is None:
        return False, NO_NODES, NO_NODES, np.zeros(0)
    return True, matrix.pattern.node_ptr, matrix.pattern.node_adj, matrix.data


def stencil_keys(stencils: np.ndarray, nodes: int) -> np.ndarray:
    """Sorted unique adjacency keys of stencils, shape [stencils, nodes a stencil]; negative nodes are left out."""
    keys = stencils[:, :, None] * nodes + stencils[:, None, :]
    inside = (stencils[:, :, None] >= 0) & (stencils[:, None, :] >= 0)
    return np.unique(keys[inside])
