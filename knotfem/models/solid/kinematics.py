"""Compiled kinematics of an integration point: deformation gradient, its inverse, deviatoric stress."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel


@kernel(inline="always")
def gather(x: np.ndarray, nodes: np.ndarray, y: np.ndarray) -> None:
    """Positions of an element's nodes into y, shape [n, 3]."""
    for a in range(nodes.size):
        for i in range(3):
            y[a, i] = x[nodes[a], i]


@kernel(inline="always", error_model="numpy")
def deformation(y: np.ndarray, grad: np.ndarray, F: np.ndarray) -> float:
    """Deformation gradient F from positions and reference gradients, both of shape [n, 3]; returns its determinant."""
    for i in range(3):
        for k in range(3):
            F[i, k] = 0.0
    for a in range(y.shape[0]):
        for i in range(3):
            F[i, 0] += y[a, i] * grad[a, 0]
            F[i, 1] += y[a, i] * grad[a, 1]
            F[i, 2] += y[a, i] * grad[a, 2]
    return (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )


@kernel(inline="always")
def refer(F: np.ndarray, J: float, height: float) -> float:
    """Refer F (3, 3) of determinant J, made with the tables, to a layer longer by a factor; returns the determinant."""
    thin = 1.0 / height
    for i in range(3):
        F[i, 2] *= thin
    return thin * J


@kernel(inline="always", error_model="numpy")
def inverse(F: np.ndarray, J: float, inv: np.ndarray) -> None:
    """Inverse of F with determinant J."""
    inv[0, 0] = (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1]) / J
    inv[0, 1] = (F[0, 2] * F[2, 1] - F[0, 1] * F[2, 2]) / J
    inv[0, 2] = (F[0, 1] * F[1, 2] - F[0, 2] * F[1, 1]) / J
    inv[1, 0] = (F[1, 2] * F[2, 0] - F[1, 0] * F[2, 2]) / J
    inv[1, 1] = (F[0, 0] * F[2, 2] - F[0, 2] * F[2, 0]) / J
    inv[1, 2] = (F[0, 2] * F[1, 0] - F[0, 0] * F[1, 2]) / J
    inv[2, 0] = (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]) / J
    inv[2, 1] = (F[0, 1] * F[2, 0] - F[0, 0] * F[2, 1]) / J
    inv[2, 2] = (F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]) / J


@kernel(inline="always", error_model="numpy")
def deviator(F: np.ndarray, scale: float, s: np.ndarray) -> float:
    """scale dev(F F^T), the deviatoric Kirchhoff stress, into s; returns tr(F F^T)."""
    trace = 0.0
    for i in range(3):
        for j in range(3):
            s[i, j] = scale * (F[i, 0] * F[j, 0] + F[i, 1] * F[j, 1] + F[i, 2] * F[j, 2])
        trace += s[i, i]
    for i in range(3):
        s[i, i] -= trace / 3.0
    return trace / scale


@kernel(inline="always", error_model="numpy")
def point_tangent(g: np.ndarray, sg: np.ndarray, count: int, mu_bar: float, pressure: float, K: np.ndarray) -> None:
    """Add K_dev + K_geo of one integration point and a linear law.

    Args:
        g: spatial gradients, shape [3, n].
        sg: s g, shape [3, n].
        count: nodes n.
        mu_bar: shear modulus times J^(-2/3) tr(b)/3 times volume.
        pressure: p J times volume.
        K: added to, shape [3, 3, n, n].
    """
    for a in range(count):
        for i in range(3):
            ga_i = g[i, a]
            a2 = -2.0 / 3.0 * (mu_bar * ga_i + sg[i, a]) + pressure * ga_i
            a3 = -2.0 / 3.0 * ga_i
            for j in range(3):
                a1 = (mu_bar - pressure) * g[j, a]
                for b in range(count):
                    K[i, j, a, b] += a1 * g[i, b] + a2 * g[j, b] + a3 * sg[j, b]
        c0 = mu_bar * g[0, a] + sg[0, a]
        c1 = mu_bar * g[1, a] + sg[1, a]
        c2 = mu_bar * g[2, a] + sg[2, a]
        for b in range(count):
            dot = c0 * g[0, b] + c1 * g[1, b] + c2 * g[2, b]
            K[0, 0, a, b] += dot
            K[1, 1, a, b] += dot
            K[2, 2, a, b] += dot


@kernel(error_model="numpy")
def add_product(factor: float, v: np.ndarray, K: np.ndarray) -> None:
    """Add factor v x v to K: what the curvature W'' of a law adds to the tangent; shapes [3, n] and [3, 3, n, n]."""
    for i in range(3):
        for j in range(3):
            for a in range(v.shape[1]):
                left = factor * v[i, a]
                for b in range(v.shape[1]):
                    K[i, j, a, b] += left * v[j, b]
