"""Compiled kernels of the incompatible modes: their forces and tangent, and how they are condensed.

The modes add sum_m psi_m t_m (x) beta_m to F, with t_m = sum_a c_am x_a the tangents at the element's centre and
beta_m unknowns of the element (transposed Wilson modes: Glaser and Armero 1997). A mode's variation is
psi_m t_m (x) h_k in space, h_k = F^-T e_k, as a node's is e_i (x) grad N_a.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from knotfem.compiled import kernel
from knotfem.models.solid.views import ModesView

SINGULAR = 1e-14
"""Smallest pivot over the largest entry of a matrix that can be solved with."""


@kernel(inline="always")
def enhance(grad: np.ndarray, functions: np.ndarray, centre: np.ndarray, inner: np.ndarray, out: np.ndarray) -> None:
    """Reference gradients as the incompatible modes, shape [k, 3], make them, into out, shape [n, 3]."""
    for a in range(grad.shape[0]):
        for i in range(3):
            value = grad[a, i]
            for m in range(inner.shape[0]):
                value += functions[m] * centre[a, m] * inner[m, i]
            out[a, i] = value


@kernel(inline="always", error_model="numpy")
def tangents(y: np.ndarray, centre: np.ndarray, t: np.ndarray) -> None:
    """Tangents at the element's centre into t, shape [k, 3]."""
    for m in range(t.shape[0]):
        for i in range(3):
            t[m, i] = 0.0
            for a in range(y.shape[0]):
                t[m, i] += centre[a, m] * y[a, i]


@kernel(error_model="numpy")
def point_modes(modes: ModesView, functions: np.ndarray, centre: np.ndarray, mu_bar: float, pressure: float) -> None:
    """Add one integration point's forces on the modes and their tangent.

    Args:
        modes: with g, sg, s and inv of this point.
        functions: psi_m, shape [k].
        centre: c_am, shape [n, k].
        mu_bar: shear modulus times J^(-2/3) tr(b)/3 times volume.
        pressure: p J times volume.
    """
    t, along, inv, s, g, sg, f, K = modes
    extra = t.shape[0]
    count = g.shape[1] - extra
    total = np.empty((3, 3))
    h_s = np.empty((3, 3))
    for k in range(3):
        for i in range(3):
            h_s[k, i] = inv[k, 0] * s[0, i] + inv[k, 1] * s[1, i] + inv[k, 2] * s[2, i]
            total[k, i] = h_s[k, i] + pressure * inv[k, i]
    for m in range(extra):
        psi = functions[m]
        for k in range(3):
            along[k, m] = psi * (t[m, 0] * inv[k, 0] + t[m, 1] * inv[k, 1] + t[m, 2] * inv[k, 2])
            sg[k, count + m] = psi * (t[m, 0] * h_s[k, 0] + t[m, 1] * h_s[k, 1] + t[m, 2] * h_s[k, 2])
            f[k, count + m] += sg[k, count + m]
    for a in range(count):
        for m in range(extra):
            psi = functions[m]
            across = (mu_bar - pressure) * psi * (g[0, a] * t[m, 0] + g[1, a] * t[m, 1] + g[2, a] * t[m, 2])
            for k in range(3):
                both = 0.0
                for i in range(3):
                    both += (mu_bar * g[i, a] + sg[i, a]) * inv[k, i]
                for i in range(3):
                    K[i, k, a, count + m] += (
                        across * inv[k, i]
                        + (pressure * g[i, a] - 2.0 / 3.0 * (mu_bar * g[i, a] + sg[i, a])) * along[k, m]
                        - 2.0 / 3.0 * g[i, a] * sg[k, count + m]
                        + psi * t[m, i] * both
                        + psi * centre[a, m] * total[k, i]
                    )
    for m in range(extra):
        for n in range(extra):
            size = functions[m] * functions[n] * (t[m, 0] * t[n, 0] + t[m, 1] * t[n, 1] + t[m, 2] * t[n, 2])
            for k in range(3):
                for r in range(3):
                    both = 0.0
                    for i in range(3):
                        both += (mu_bar * inv[k, i] + h_s[k, i]) * inv[r, i]
                    K[k, r, count + m, count + n] += (
                        (mu_bar - pressure) * along[k, n] * along[r, m]
                        + (pressure * along[k, m] - 2.0 / 3.0 * (mu_bar * along[k, m] + sg[k, count + m])) * along[r, n]
                        - 2.0 / 3.0 * along[k, m] * sg[r, count + n]
                        + size * both
                    )


@kernel(error_model="numpy")
def eliminate(A: np.ndarray, B: np.ndarray) -> float:
    """Solve A X = B by Gauss elimination with partial pivoting.

    Args:
        A: shape [n, n], overwritten.
        B: shape [n, m], becomes X.

    Returns:
        The smallest pivot over the largest entry; below `SINGULAR` there is no solution, and B is of no use.
    """
    size, columns = B.shape
    largest = 0.0
    for r in range(size):
        for c in range(size):
            largest = max(largest, abs(A[r, c]))
    smallest = largest
    for r in range(size):
        pivot = r
        for t in range(r + 1, size):
            if abs(A[t, r]) > abs(A[pivot, r]):
                pivot = t
        smallest = min(smallest, abs(A[pivot, r]))
        if not smallest > SINGULAR * largest:
            return 0.0
        if pivot != r:
            for c in range(r, size):
                A[r, c], A[pivot, c] = A[pivot, c], A[r, c]
            for c in range(columns):
                B[r, c], B[pivot, c] = B[pivot, c], B[r, c]
        for t in range(r + 1, size):
            ratio = A[t, r] / A[r, r]
            for c in range(r + 1, size):
                A[t, c] -= ratio * A[r, c]
            for c in range(columns):
                B[t, c] -= ratio * B[r, c]
    for r in range(size - 1, -1, -1):
        for t in range(r + 1, size):
            for c in range(columns):
                B[r, c] -= A[r, t] * B[t, c]
        for c in range(columns):
            B[r, c] /= A[r, r]
    return smallest / largest


@kernel(error_model="numpy")
def condense_modes(f: np.ndarray, K: np.ndarray, A: np.ndarray, follow: np.ndarray) -> float:
    """Take the incompatible modes, which stand behind the nodes, out of the nodes' forces and stiffness.

    Args:
        f: changed, shape [3, n + k].
        K: changed, shape [3, 3, n + k, n + k]; of the coupling only K_x,beta is read.
        A: work space, shape [3 k, 3 k].
        follow: A^-1 [K_beta,x, f_beta], by which the modes follow the nodes, filled, shape [3 k, 3 n + 1].

    Returns:
        Smallest pivot over the largest entry of A; 0 where A is singular: the modes are then left as they are.
    """
    size, last = A.shape[0], follow.shape[1] - 1
    count = last // 3
    for r in range(size):
        for c in range(size):
            A[r, c] = K[r % 3, c % 3, count + r // 3, count + c // 3]
        for b in range(count):
            for j in range(3):
                follow[r, 3 * b + j] = K[j, r % 3, b, count + r // 3]
        follow[r, last] = f[r % 3, count + r // 3]
    pivot = eliminate(A, follow)
    if pivot == 0.0:
        follow[:] = 0.0
    for r in range(size):
        k, place = r % 3, count + r // 3
        for i in range(3):
            for a in range(count):
                c = K[i, k, a, place]
                f[i, a] -= c * follow[r, last]
                for j in range(3):
                    for b in range(count):
                        K[i, j, a, b] -= c * follow[r, 3 * b + j]
    return pivot


@kernel(parallel=True)
def mode_increment(du: np.ndarray, nodes: np.ndarray, follow: np.ndarray, change: np.ndarray) -> None:
    """-A^-1 (f_beta + K_beta,x du) of the incompatible modes, into change, shape [slices, quads, k, 3]."""
    slices, quads, count = nodes.shape
    for layer in prange(slices):
        for e in range(quads):
            for r in range(follow.shape[2]):
                value = follow[layer, e, r, 3 * count]
                for a in range(count):
                    node = nodes[layer, e, a]
                    for i in range(3):
                        value += follow[layer, e, r, 3 * a + i] * du[node, i]
                change[layer, e, r // 3, r % 3] = -value
