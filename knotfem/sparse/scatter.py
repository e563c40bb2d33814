"""Scatter of dense blocks into the values of a block-sparse matrix.

Unknowns come in blocks of one width a node (three of a solid's, four of a rod's), and so does the matrix. The place of
a block in the value array follows from the node adjacency alone, so that no scatter map is stored: with d the number of
neighbours of node a and w the width, row i of node a begins at w^2 p_a + w d i, p_a being the start of its neighbours.
A symmetric matrix keeps its upper triangle, which leaves out w (w - 1)/2 values of each node before and i of each row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel


class MatrixView(NamedTuple):
    """What a compiled loop needs of a matrix.

    Attributes:
        wanted: whether there is one; without, only the residual is assembled.
        node_ptr: start of each node's neighbours, shape [nodes + 1].
        node_adj: neighbours of each node, ascending.
        data: values, shape [entries].
        components: unknowns of a node, counted from 0; their number, the width, is known when a kernel is compiled.
        upper: whether only the upper triangle is stored.
    """

    wanted: bool
    node_ptr: np.ndarray
    node_adj: np.ndarray
    data: np.ndarray
    components: tuple[int, ...]
    upper: bool


@kernel(inline="always")
def block_slot(node_ptr: np.ndarray, node_adj: np.ndarray, a: int, b: int) -> int:
    """Place of node b among the neighbours of node a, or -1."""
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
def row_start(node_ptr: np.ndarray, width: int, upper: bool, a: int, i: int) -> int:
    """Offset of row i of node a, such that entry (slot, j) stands at start + width slot + j."""
    degree = node_ptr[a + 1] - node_ptr[a]
    start = width * width * node_ptr[a] + width * degree * i
    if upper:
        start -= (width * (width - 1)) // 2 * a + (i * (i - 1)) // 2 + i
    return start


@kernel
def add_blocks(matrix: MatrixView, rows: np.ndarray, columns: np.ndarray, block: np.ndarray) -> bool:
    """Add a dense block over nodes; negative nodes are left out, and the lower triangle of a symmetric matrix.

    The arrays of the view are taken out of it once: to hand the view to a function for each pair of nodes takes longer
    than to add their block.

    Args:
        matrix: to add to.
        rows: nodes, shape [n].
        columns: nodes, shape [m].
        block: shape [n width, m width].

    Returns:
        False where a part of it lies outside the pattern.
    """
    width, upper = len(matrix.components), matrix.upper
    node_ptr, node_adj, data = matrix.node_ptr, matrix.node_adj, matrix.data
    for p in range(rows.size):
        a = rows[p]
        if a < 0:
            continue
        for q in range(columns.size):
            b = columns[q]
            if b < 0 or (upper and b < a):
                continue
            slot = block_slot(node_ptr, node_adj, a, b)
            if slot < 0:
                return False
            for i in range(width):
                start = row_start(node_ptr, width, upper, a, i) + width * slot
                for j in range(i if upper and a == b else 0, width):
                    data[start + j] += block[width * p + i, width * q + j]
    return True


@kernel
def add_node_blocks(matrix: MatrixView, nodes: np.ndarray, blocks: np.ndarray) -> bool:
    """Add to the places of each node, shape [n], its own block over x, y and z, shape [n, 3, 3].

    Returns:
        False where one lies outside the pattern.
    """
    width = len(matrix.components)
    wide = np.zeros((width, width))
    for k in range(nodes.size):
        wide[:3, :3] = blocks[k]
        node = nodes[k : k + 1]
        if not add_blocks(matrix, node, node, wide):
            return False
    return True
