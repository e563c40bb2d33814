"""Sparsity of a system of three unknowns a node: built once, filled many times.

The scalar CSR pattern consists of dense 3 x 3 node blocks. A block's place in the value array follows from the node
adjacency alone, so that no scatter map is stored. Explicit zeros stay: the analysis of a direct solver keeps holding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numba import prange

from knotfem.compiled import kernel


@kernel(inline="always")
def block_slot(node_ptr, node_adj, a, b):
    """Place of node b in the sorted adjacency of node a, or -1."""
    low, high = node_ptr[a], node_ptr[a + 1] - 1
    while low <= high:
        middle = (low + high) >> 1
        found = node_adj[middle]
        if found == b:
            return middle - node_ptr[a]
        if found < b:
            low = middle + 1
        else:
            high = middle - 1
    return -1


@kernel(inline="always")
def row_start(node_ptr, upper, a, i):
    """Offset in the value array of row i of node a, such that entry (slot, j) stands at start + 3 slot + j."""
    degree = node_ptr[a + 1] - node_ptr[a]
    start = 9 * node_ptr[a] + 3 * degree * i
    if upper:
        start -= 3 * a + (i * (i - 1)) // 2 + i
    return start


@kernel
def _expand(node_ptr, node_adj, upper, indptr, indices):
    for a in range(node_ptr.size - 1):
        degree = node_ptr[a + 1] - node_ptr[a]
        for i in range(3):
            start = row_start(node_ptr, upper, a, i)
            indptr[3 * a + i] = start + (i if upper else 0)
            for k in range(degree):
                b = node_adj[node_ptr[a] + k]
                for j in range(3):
                    if not upper or k > 0 or j >= i:
                        indices[start + 3 * k + j] = 3 * b + j


@kernel(parallel=True)
def _constrain(indptr, indices, data, fixed, scale):
    for row in prange(indptr.size - 1):
        for k in range(indptr[row], indptr[row + 1]):
            column = indices[k]
            if fixed[row] or fixed[column]:
                data[k] = scale if row == column else 0.0


@kernel
def _add_diagonal(indptr, indices, data, values):
    for row in range(indptr.size - 1):
        for k in range(indptr[row], indptr[row + 1]):
            if indices[k] == row:
                data[k] += values[row]
                break


@kernel(parallel=True)
def _multiply(indptr, indices, data, x, y):
    for row in prange(indptr.size - 1):
        value = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            value += data[k] * x[indices[k]]
        y[row] = value


@kernel
def _multiply_upper(indptr, indices, data, x, y):
    y[:] = 0.0
    for row in range(indptr.size - 1):
        value = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            column = indices[k]
            value += data[k] * x[column]
            if column != row:
                y[column] += data[k] * x[row]
        y[row] += value


@kernel
def add_blocks(nodes, blocks, node_ptr, node_adj, upper, data):
    """Add a dense square matrix over `nodes` (n,), `blocks` (3n, 3n). Returns False when a block lies outside."""
    count = nodes.size
    for p in range(count):
        a = nodes[p]
        for q in range(count):
            b = nodes[q]
            if upper and b < a:
                continue
            slot = block_slot(node_ptr, node_adj, a, b)
            if slot < 0:
                return False
            for i in range(3):
                start = row_start(node_ptr, upper, a, i) + 3 * slot
                for j in range(3):
                    if upper and a == b and j < i:
                        continue
                    data[start + j] += blocks[3 * p + i, 3 * q + j]
    return True


@kernel
def add_node_blocks(nodes, blocks, node_ptr, node_adj, upper, data):
    """Add to the diagonal block of each of `nodes` (n,) its own `blocks` (n, 3, 3). Returns whether all have one."""
    one = np.empty(1, np.int64)
    complete = True
    for k in range(nodes.size):
        one[0] = nodes[k]
        complete &= add_blocks(one, blocks[k], node_ptr, node_adj, upper, data)
    return complete


@dataclass(frozen=True, eq=False)
class Pattern:
    """Sparsity of a matrix over nodes with three unknowns each.

    Attributes:
        node_ptr: shape [nodes + 1], start of each node's neighbours.
        node_adj: neighbours, ascending; with `upper` only those not below the node itself.
        upper: only the upper triangle is stored (symmetric systems).
    """

    node_ptr: np.ndarray
    node_adj: np.ndarray
    upper: bool

    @classmethod
    def from_keys(cls, keys: np.ndarray, nodes: int, upper: bool) -> Self:
        """Pattern from sorted unique keys a * nodes + b of a structurally symmetric adjacency (diagonal included)."""
        a, b = np.divmod(keys, nodes)
        if upper:
            keep = b >= a
            a, b = a[keep], b[keep]
        node_ptr = np.zeros(nodes + 1, dtype=np.int64)
        np.cumsum(np.bincount(a, minlength=nodes), out=node_ptr[1:])
        return cls(node_ptr, b.astype(np.int64), upper)

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return 3 * (self.node_ptr.size - 1)

    @cached_property
    def csr(self) -> tuple[np.ndarray, np.ndarray]:
        """Scalar (indptr, indices), both int32."""
        nodes = self.node_ptr.size - 1
        entries = 9 * self.node_adj.size - (3 * nodes if self.upper else 0)
        indptr = np.empty(3 * nodes + 1, dtype=np.int32)
        indices = np.empty(entries, dtype=np.int32)
        _expand(self.node_ptr, self.node_adj, self.upper, indptr, indices)
        indptr[-1] = entries
        return indptr, indices


class Matrix:
    """Values over a fixed pattern."""

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self.data = np.zeros(pattern.csr[1].size)

    def clear(self) -> None:
        self.data[:] = 0.0

    def add_diagonal(self, values: np.ndarray) -> None:
        """Add one value an unknown, shape [3 nodes], to the diagonal."""
        _add_diagonal(*self.pattern.csr, self.data, values)

    def constrain(self, fixed: np.ndarray, scale: float = 1.0) -> None:
        """Replace rows and columns of the `fixed` unknowns, boolean [3 nodes], by `scale` on the diagonal."""
        _constrain(*self.pattern.csr, self.data, fixed, scale)

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """Product with a vector, shape [3 nodes]."""
        y = np.empty_like(x)
        multiply = _multiply_upper if self.pattern.upper else _multiply
        multiply(*self.pattern.csr, self.data, x, y)
        return y

    def to_scipy(self):
        """The whole matrix as a SciPy CSR array (both triangles)."""
        from scipy.sparse import csr_array, triu

        indptr, indices = self.pattern.csr
        matrix = csr_array((self.data, indices, indptr), shape=(self.pattern.size, self.pattern.size))
        return csr_array(matrix + triu(matrix, 1).T) if self.pattern.upper else matrix


def element_keys(connectivity: np.ndarray, nodes: int) -> np.ndarray:
    """Sorted unique adjacency keys a * nodes + b of elements, `connectivity` shape [elements, nodes an element]."""
    conn = connectivity.astype(np.int64)
    keys = conn[:, :, None] * nodes + conn[:, None, :]
    return np.unique(keys.ravel())


def merge_keys(*parts: np.ndarray) -> np.ndarray:
    """Union of adjacency keys."""
    return np.unique(np.concatenate(parts))
