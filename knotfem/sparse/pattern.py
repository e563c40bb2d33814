"""Sparsity of a system with one block of unknowns a node: built once, filled many times.

The scalar CSR pattern consists of dense node blocks, three wide for solids and four for rods (see
`knotfem.sparse.scatter`). Explicit zeros stay: the analysis of a direct solver keeps holding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numba import prange

from knotfem.compiled import kernel
from knotfem.sparse.scatter import MatrixView, row_start

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@kernel
def _expand(
    node_ptr: np.ndarray, node_adj: np.ndarray, width: int, upper: bool, indptr: np.ndarray, indices: np.ndarray
) -> None:
    for a in range(node_ptr.size - 1):
        degree = node_ptr[a + 1] - node_ptr[a]
        for i in range(width):
            start = row_start(node_ptr, width, upper, a, i)
            indptr[width * a + i] = start + (i if upper else 0)
            for k in range(degree):
                b = node_adj[node_ptr[a] + k]
                for j in range(width):
                    if not upper or k > 0 or j >= i:
                        indices[start + width * k + j] = width * b + j


@kernel(parallel=True)
def _constrain(indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, fixed: np.ndarray) -> None:
    for row in prange(indptr.size - 1):
        for k in range(indptr[row], indptr[row + 1]):
            column = indices[k]
            if fixed[row] or fixed[column]:
                data[k] = 1.0 if row == column else 0.0


@kernel
def _add_diagonal(indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, values: np.ndarray) -> None:
    for row in range(indptr.size - 1):
        for k in range(indptr[row], indptr[row + 1]):
            if indices[k] == row:
                data[k] += values[row]
                break


@kernel(parallel=True)
def _multiply(indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
    for row in prange(indptr.size - 1):
        value = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            value += data[k] * x[indices[k]]
        y[row] = value


@kernel
def _multiply_upper(indptr: np.ndarray, indices: np.ndarray, data: np.ndarray, x: np.ndarray, y: np.ndarray) -> None:
    y[:] = 0.0
    for row in range(indptr.size - 1):
        value = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            column = indices[k]
            value += data[k] * x[column]
            if column != row:
                y[column] += data[k] * x[row]
        y[row] += value


@dataclass(frozen=True, eq=False)
class Pattern:
    """Sparsity of a matrix over nodes with one block of unknowns each.

    Attributes:
        node_ptr: shape [nodes + 1], start of each node's neighbours.
        node_adj: neighbours, ascending; with `upper` only those not below the node itself.
        upper: only the upper triangle is stored (symmetric systems).
        width: unknowns of a node.
    """

    node_ptr: np.ndarray
    node_adj: np.ndarray
    upper: bool
    width: int = 3

    @classmethod
    def from_keys(cls, keys: np.ndarray, nodes: int, upper: bool, width: int = 3) -> Self:
        """Pattern from sorted unique keys a * nodes + b of a structurally symmetric adjacency (diagonal included)."""
        a, b = np.divmod(keys, nodes)
        if upper:
            keep = b >= a
            a, b = a[keep], b[keep]
        node_ptr = np.zeros(nodes + 1, dtype=np.int64)
        np.cumsum(np.bincount(a, minlength=nodes), out=node_ptr[1:])
        return cls(node_ptr, b.astype(np.int64), upper, width)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.node_ptr.size - 1

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return self.width * self.nodes

    @cached_property
    def csr(self) -> tuple[np.ndarray, np.ndarray]:
        """Scalar (indptr, indices), both int32."""
        w = self.width
        entries = w * w * self.node_adj.size - (w * (w - 1) // 2 * self.nodes if self.upper else 0)
        indptr = np.empty(self.size + 1, dtype=np.int32)
        indices = np.empty(entries, dtype=np.int32)
        _expand(self.node_ptr, self.node_adj, w, self.upper, indptr, indices)
        indptr[-1] = entries
        return indptr, indices


class Matrix:
    """Values over a fixed pattern."""

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self.data = np.zeros(pattern.csr[1].size)
        components = tuple(range(pattern.width))
        self.view = MatrixView(True, pattern.node_ptr, pattern.node_adj, self.data, components, pattern.upper)

    def clear(self) -> None:
        """Set all values to zero."""
        self.data[:] = 0.0

    def add_diagonal(self, values: np.ndarray) -> None:
        """Add one value for each unknown, shape [unknowns], to the diagonal."""
        _add_diagonal(*self.pattern.csr, self.data, values)

    def constrain(self, fixed: np.ndarray) -> None:
        """Replace rows and columns of the `fixed` unknowns, boolean [unknowns], by 1 on the diagonal."""
        _constrain(*self.pattern.csr, self.data, fixed)

    def multiply(self, x: np.ndarray) -> np.ndarray:
        """Product with a vector, shape [unknowns]."""
        y = np.empty_like(x)
        multiply = _multiply_upper if self.pattern.upper else _multiply
        multiply(*self.pattern.csr, self.data, x, y)
        return y

    def to_scipy(self) -> csr_array:
        """The whole matrix as a SciPy CSR array (both triangles)."""
        from scipy.sparse import csr_array, triu

        indptr, indices = self.pattern.csr
        matrix = csr_array((self.data, indices, indptr), shape=(self.pattern.size, self.pattern.size))
        return csr_array(matrix + triu(matrix, 1).T) if self.pattern.upper else matrix


@cache
def _no_matrix(width: int) -> MatrixView:
    nowhere = np.zeros(0, dtype=np.int64)
    return MatrixView(False, nowhere, nowhere, np.zeros(0), tuple(range(width)), False)


def view_of(matrix: Matrix | None, width: int) -> MatrixView:
    """What compiled loops take of a matrix, or of none where only the residual is wanted.

    Args:
        matrix: values, or None.
        width: unknowns of a node.
    """
    return _no_matrix(width) if matrix is None else matrix.view


def stencil_keys(stencils: np.ndarray, nodes: int) -> np.ndarray:
    """Sorted unique adjacency keys a * nodes + b of all pairs of nodes within each stencil.

    Args:
        stencils: nodes, shape [stencils, nodes of a stencil]; negative ones are left out.
        nodes: number of nodes of the system.
    """
    s = np.asarray(stencils, dtype=np.int64)
    keys = s[:, :, None] * nodes + s[:, None, :]
    if s.size and s.min() < 0:
        keys = keys[(s[:, :, None] >= 0) & (s[:, None, :] >= 0)]
    return np.unique(keys)


def merge_keys(*parts: np.ndarray) -> np.ndarray:
    """Union of adjacency keys."""
    return np.unique(np.concatenate(parts))
