"""Compiled kernels of mixed hexahedra: neo-Hookean deviator, element pressure condensed.

With W = mu/2 (J^(-2/3) tr b - 3) and the pressure p = sum_q p_q psi_q an unknown of its own,

    R_q  = int psi_q (J - 1) dV - (G p)_q          G = (1/kappa) int psi psi^T dV
    b_q  = int psi_q J grad(N) dV                  (spatial gradients)
    f    = f_dev + b^T (p + G^-1 R)                K = K_dev + K_geo(p) + b^T G^-1 b
    dp   = G^-1 (R + b . du)                       after the linear solve

which for constant psi is the mean-dilatation element (Simo, Taylor and Pister 1985) with the pressure kept through
the Newton iteration. Reference gradients depend on the section's quadrilateral only, all slices being alike.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from knotfem.solver.sparsity import block_slot, row_start


@njit(cache=True)
def element_slots(elements, node_ptr, node_adj, slots):
    """Adjacency slots of all node pairs of all elements; `slots` shape [elements, n, n], -1 where not stored."""
    for e in range(elements.shape[0]):
        for a in range(elements.shape[1]):
            for b in range(elements.shape[1]):
                slots[e, a, b] = block_slot(node_ptr, node_adj, elements[e, a], elements[e, b])


@njit(cache=True, inline="always", error_model="numpy")
def deformation(x, nodes, grad, F):
    """Deformation gradient F (3, 3) from reference gradients (n, 3); returns its determinant."""
    for i in range(3):
        for k in range(3):
            F[i, k] = 0.0
    for a in range(nodes.size):
        n = nodes[a]
        for i in range(3):
            xi = x[n, i]
            F[i, 0] += xi * grad[a, 0]
            F[i, 1] += xi * grad[a, 1]
            F[i, 2] += xi * grad[a, 2]
    return (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )


@njit(cache=True, inline="always", error_model="numpy")
def inverse(F, J, inv):
    """Inverse (3, 3) of F with determinant J."""
    inv[0, 0] = (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1]) / J
    inv[0, 1] = (F[0, 2] * F[2, 1] - F[0, 1] * F[2, 2]) / J
    inv[0, 2] = (F[0, 1] * F[1, 2] - F[0, 2] * F[1, 1]) / J
    inv[1, 0] = (F[1, 2] * F[2, 0] - F[1, 0] * F[2, 2]) / J
    inv[1, 1] = (F[0, 0] * F[2, 2] - F[0, 2] * F[2, 0]) / J
    inv[1, 2] = (F[0, 2] * F[1, 0] - F[0, 0] * F[1, 2]) / J
    inv[2, 0] = (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]) / J
    inv[2, 1] = (F[0, 1] * F[2, 0] - F[0, 0] * F[2, 1]) / J
    inv[2, 2] = (F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]) / J


@njit(cache=True, inline="always", error_model="numpy")
def deviator(F, scale, s):
    """Deviatoric Kirchhoff stress scale * dev(F F^T) into s (3, 3); returns tr(F F^T)."""
    trace = 0.0
    for i in range(3):
        for j in range(3):
            s[i, j] = scale * (F[i, 0] * F[j, 0] + F[i, 1] * F[j, 1] + F[i, 2] * F[j, 2])
        trace += s[i, i]
    for i in range(3):
        s[i, i] -= trace / 3.0
    return trace / scale


@njit(cache=True, inline="always", error_model="numpy")
def _point_tangent(g, sg, count, mu_bar, pressure, K):
    """Add one integration point's K_dev + K_geo; g, sg (3, n): spatial gradients and s g; K (3, 3, n, n)."""
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


@njit(cache=True, parallel=True, error_model="numpy")
def assemble(
    x,
    elements,
    grads,
    weights,
    psi,
    compliance_inv,
    mu,
    p,
    residual,
    tangent,
    data,
    slots,
    node_ptr,
    upper,
    b_out,
    R_out,
):
    """Residual and, where `tangent`, the condensed tangent of all elements.

    Args:
        x: positions, shape [nodes, 3].
        elements: shape [slices, quads, n].
        grads: reference gradients, shape [quads, points, n, 3].
        weights: reference volumes, shape [quads, points].
        psi: pressure functions, shape [points, q].
        compliance_inv: G^-1, shape [quads, q, q].
        mu: shear modulus.
        p: element pressures, shape [slices, quads, q].
        residual: added to, shape [nodes, 3].
        tangent: whether the matrix values `data` are added to as well.
        data, slots, node_ptr, upper: the matrix, see `Pattern`.
        b_out, R_out: kept for the pressure update, shapes [slices, quads, q, 3 n] and [slices, quads, q].

    Returns:
        Smallest determinant of the deformation gradient.
    """
    slices, quads, count = elements.shape
    points = weights.shape[1]
    modes = psi.shape[1]
    worst = np.full(slices, np.inf)
    for colour in range(2):
        for pair in prange((slices + 1 - colour) // 2):
            layer = 2 * pair + colour
            F = np.empty((3, 3))
            inv = np.empty((3, 3))
            s = np.empty((3, 3))
            g = np.empty((3, count))
            sg = np.empty((3, count))
            f = np.empty((3, count))
            K = np.empty((3, 3, count, count))
            b = np.empty((modes, 3, count))
            R = np.empty(modes)
            total = np.empty(modes)
            for e in range(quads):
                nodes = elements[layer, e]
                f[:] = 0.0
                b[:] = 0.0
                R[:] = 0.0
                if tangent:
                    K[:] = 0.0
                for q in range(points):
                    grad = grads[e, q]
                    w = weights[e, q]
                    J = deformation(x, nodes, grad, F)
                    worst[layer] = min(worst[layer], J)
                    inverse(F, J, inv)
                    trace = deviator(F, mu * w * abs(J) ** (-2.0 / 3.0), s)
                    mu_bar = mu * w * abs(J) ** (-2.0 / 3.0) * trace / 3.0
                    pressure = 0.0
                    for m in range(modes):
                        pressure += psi[q, m] * p[layer, e, m]
                        R[m] += psi[q, m] * w * (J - 1.0)
                    for a in range(count):
                        for i in range(3):
                            g[i, a] = grad[a, 0] * inv[0, i] + grad[a, 1] * inv[1, i] + grad[a, 2] * inv[2, i]
                        for i in range(3):
                            sg[i, a] = s[i, 0] * g[0, a] + s[i, 1] * g[1, a] + s[i, 2] * g[2, a]
                            f[i, a] += sg[i, a]
                            for m in range(modes):
                                b[m, i, a] += psi[q, m] * w * J * g[i, a]
                    if tangent:
                        _point_tangent(g, sg, count, mu_bar, pressure * w * J, K)
                for m in range(modes):
                    total[m] = p[layer, e, m]
                # G p = kappa-scaled mass; R_q = int psi (J - 1) - (G p)_q is formed with G^-1: G^-1 R = G^-1 int - p
                for m in range(modes):
                    value = 0.0
                    for k in range(modes):
                        value += compliance_inv[e, m, k] * R[k]
                    total[m] = value
                for m in range(modes):
                    R_out[layer, e, m] = total[m] - p[layer, e, m]
                for m in range(modes):
                    for i in range(3):
                        for a in range(count):
                            f[i, a] += total[m] * b[m, i, a]
                            b_out[layer, e, m, 3 * a + i] = b[m, i, a]
                for a in range(count):
                    for i in range(3):
                        residual[nodes[a], i] += f[i, a]
                if not tangent:
                    continue
                for m in range(modes):
                    for k in range(modes):
                        c = compliance_inv[e, m, k]
                        for i in range(3):
                            for j in range(3):
                                for a in range(count):
                                    cb = c * b[m, i, a]
                                    for d in range(count):
                                        K[i, j, a, d] += cb * b[k, j, d]
                flat = layer * quads + e
                for a in range(count):
                    node = nodes[a]
                    for i in range(3):
                        start = row_start(node_ptr, upper, node, i)
                        for d in range(count):
                            slot = slots[flat, a, d]
                            if slot < 0:
                                continue
                            place = start + 3 * slot
                            if upper and a == d:
                                for j in range(i, 3):
                                    data[place + j] += K[i, j, a, d]
                            else:
                                data[place] += K[i, 0, a, d]
                                data[place + 1] += K[i, 1, a, d]
                                data[place + 2] += K[i, 2, a, d]
    return worst.min() if slices > 0 else np.inf


@njit(cache=True, parallel=True)
def pressure_increment(du, elements, compliance_inv, b, excess, dp):
    """dp = G^-1 (R + b . du), with `excess` = G^-1 R; shapes as in `assemble`."""
    slices, quads, count = elements.shape
    modes = dp.shape[2]
    for layer in prange(slices):
        change = np.empty(modes)
        for e in range(quads):
            for m in range(modes):
                value = 0.0
                for a in range(count):
                    node = elements[layer, e, a]
                    for i in range(3):
                        value += b[layer, e, m, 3 * a + i] * du[node, i]
                change[m] = value
            for m in range(modes):
                value = excess[layer, e, m]
                for k in range(modes):
                    value += compliance_inv[e, m, k] * change[k]
                dp[layer, e, m] = value


@njit(cache=True, parallel=True, error_model="numpy")
def merit(x, elements, grads, weights, psi, mu, p, modulus):
    """Sum of W_dev + p (J - 1) + modulus/2 (theta - 1)^2 and the smallest J.

    The augmented Lagrangian of the mixed element with a moderate modulus; modulus = 0 with the converged pressure
    leaves W_dev + p (theta - 1).
    """
    slices, quads, _ = elements.shape
    points = weights.shape[1]
    modes = psi.shape[1]
    sums = np.zeros(slices)
    worst = np.full(slices, np.inf)
    for layer in prange(slices):
        F = np.empty((3, 3))
        value = 0.0
        for e in range(quads):
            volume = 0.0
            dilatation = 0.0
            for q in range(points):
                w = weights[e, q]
                J = deformation(x, elements[layer, e], grads[e, q], F)
                worst[layer] = min(worst[layer], J)
                trace = 0.0
                for i in range(3):
                    for k in range(3):
                        trace += F[i, k] * F[i, k]
                pressure = 0.0
                for m in range(modes):
                    pressure += psi[q, m] * p[layer, e, m]
                value += w * (0.5 * mu * (abs(J) ** (-2.0 / 3.0) * trace - 3.0) + pressure * (J - 1.0))
                volume += w
                dilatation += w * (J - 1.0)
            value += 0.5 * modulus * dilatation * dilatation / volume
        sums[layer] = value
    return sums.sum(), worst.min() if slices > 0 else np.inf
