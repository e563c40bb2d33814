"""Compiled kernels of mixed hexahedra: neo-Hookean deviator, element pressure and incompatible modes condensed.

With W = mu/2 (J^(-2/3) tr b - 3) and the pressure p = sum_q p_q psi_q an unknown of its own,

    R_q  = int psi_q (J - 1) dV - (G p)_q          G = (1/kappa) int psi psi^T dV
    b_q  = int psi_q J grad(N) dV                  (spatial gradients)
    f    = f_dev + b^T (p + G^-1 R)                K = K_dev + K_geo(p) + b^T G^-1 b
    dp   = G^-1 (R + b . du)                       after the linear solve

which for constant psi is the mean-dilatation element (Simo, Taylor and Pister 1985) with the pressure kept through
the Newton iteration. Reference gradients depend on the section's quadrilateral only, all slices being alike.

Incompatible modes add sum_m psi_m t_m (x) beta_m to F, with t_m = sum_a c_am x_a the tangents at the element's centre
and beta_m unknowns of the element (transposed Wilson modes: Glaser and Armero 1997). They change the reference
gradients to grad N_a + sum_m psi_m c_am beta_m and no more. With A = K_beta,beta, once the pressure is condensed,

    f   -= K_x,beta A^-1 f_beta      K -= K_x,beta A^-1 K_beta,x
    dbeta = -A^-1 (f_beta + K_beta,x du)
"""

from __future__ import annotations

import numpy as np
from numba import prange

from knotfem.compiled import kernel
from knotfem.sparse.pattern import block_slot, row_start


@kernel
def element_slots(elements, node_ptr, node_adj, slots):
    """Adjacency slots of all node pairs of all elements; `slots` shape [elements, n, n], -1 where not stored."""
    for e in range(elements.shape[0]):
        for a in range(elements.shape[1]):
            for b in range(elements.shape[1]):
                slots[e, a, b] = block_slot(node_ptr, node_adj, elements[e, a], elements[e, b])


@kernel(inline="always")
def gather(x, nodes, y):
    """Positions of an element's nodes into y (n, 3)."""
    for a in range(nodes.size):
        for i in range(3):
            y[a, i] = x[nodes[a], i]


@kernel(inline="always")
def enhance(grad, functions, centre, inner, out):
    """Reference gradients as the incompatible modes, shape [k, 3], make them, into out (n, 3)."""
    for a in range(grad.shape[0]):
        for i in range(3):
            value = grad[a, i]
            for m in range(inner.shape[0]):
                value += functions[m] * centre[a, m] * inner[m, i]
            out[a, i] = value


@kernel(inline="always", error_model="numpy")
def deformation(y, grad, F):
    """Deformation gradient F (3, 3) from positions and reference gradients, both (n, 3); returns its determinant."""
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


@kernel(inline="always", error_model="numpy")
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


@kernel(inline="always", error_model="numpy")
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


@kernel(inline="always", error_model="numpy")
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


@kernel(inline="always", error_model="numpy")
def tangents(y, centre, t):
    """Tangents at the element's centre into t (k, 3)."""
    for m in range(t.shape[0]):
        for i in range(3):
            t[m, i] = 0.0
            for a in range(y.shape[0]):
                t[m, i] += centre[a, m] * y[a, i]


@kernel(error_model="numpy")
def _point_modes(count, t, functions, centre, inv, s, g, sg, mu_bar, pressure, f, K, along):
    """Add one integration point's forces on the modes and their tangent.

    A mode's variation is psi_m t_m (x) h_k in space, h_k = F^-T e_k, as a node's is e_i (x) grad N_a.

    Args:
        count: nodes n; the modes stand behind them in f (3, n + k) and K (3, 3, n + k, n + k).
        t, functions, centre: tangents (k, 3), psi_m (k) and c_am (n, k).
        inv, s: inverse of F and deviatoric Kirchhoff stress times volume.
        g, sg: spatial gradients and s g, shapes (3, n).
        mu_bar, pressure: as for the nodes, times volume.
        along: psi_m t_m . h_k for the change of volume, shape [3, k].
    """
    extra = t.shape[0]
    total = np.empty((3, 3))
    h_s = np.empty((3, 3))
    bent = np.empty((3, extra))
    for k in range(3):
        for i in range(3):
            h_s[k, i] = inv[k, 0] * s[0, i] + inv[k, 1] * s[1, i] + inv[k, 2] * s[2, i]
            total[k, i] = h_s[k, i] + pressure * inv[k, i]
    for m in range(extra):
        psi = functions[m]
        for k in range(3):
            along[k, m] = psi * (t[m, 0] * inv[k, 0] + t[m, 1] * inv[k, 1] + t[m, 2] * inv[k, 2])
            bent[k, m] = psi * (t[m, 0] * h_s[k, 0] + t[m, 1] * h_s[k, 1] + t[m, 2] * h_s[k, 2])
            f[k, count + m] += bent[k, m]
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
                        - 2.0 / 3.0 * g[i, a] * bent[k, m]
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
                        + (pressure * along[k, m] - 2.0 / 3.0 * (mu_bar * along[k, m] + bent[k, m])) * along[r, n]
                        - 2.0 / 3.0 * along[k, m] * bent[r, n]
                        + size * both
                    )


@kernel(error_model="numpy")
def _condense_modes(count, f, K, A, follow):
    """Take the incompatible modes, which stand behind `count` nodes in f (3, n + k) and K, out of the nodes' part.

    Args:
        count: nodes n.
        f, K: changed, shapes [3, n + k] and [3, 3, n + k, n + k].
        A: work space, shape [3 k, 3 k].
        follow: A^-1 [K_beta,x, f_beta], by which the modes follow the nodes, shape [3 k, 3 n + 1].
    """
    size, last = A.shape[0], 3 * count
    for r in range(size):
        for c in range(size):
            A[r, c] = K[r % 3, c % 3, count + r // 3, count + c // 3]
        for b in range(count):
            for j in range(3):
                follow[r, 3 * b + j] = K[j, r % 3, b, count + r // 3]
        follow[r, last] = f[r % 3, count + r // 3]
    for r in range(size):
        for t in range(r + 1, size):
            ratio = A[t, r] / A[r, r]
            for c in range(r + 1, size):
                A[t, c] -= ratio * A[r, c]
            for c in range(last + 1):
                follow[t, c] -= ratio * follow[r, c]
    for r in range(size - 1, -1, -1):
        for t in range(r + 1, size):
            for c in range(last + 1):
                follow[r, c] -= A[r, t] * follow[t, c]
        for c in range(last + 1):
            follow[r, c] /= A[r, r]
    for r in range(size):
        k, place = r % 3, count + r // 3
        for i in range(3):
            for a in range(count):
                c = K[i, k, a, place]
                f[i, a] -= c * follow[r, last]
                for j in range(3):
                    for b in range(count):
                        K[i, j, a, b] -= c * follow[r, 3 * b + j]


@kernel(parallel=True, error_model="numpy")
def assemble(
    x,
    elements,
    grads,
    weights,
    psi,
    functions,
    centre,
    compliance_inv,
    mu,
    p,
    inner,
    residual,
    tangent,
    data,
    slots,
    node_ptr,
    upper,
    b_out,
    R_out,
    follow_out,
):
    """Residual and, where `tangent`, the condensed tangent of all elements.

    Args:
        x: positions, shape [nodes, 3].
        elements: shape [slices, quads, n].
        grads: reference gradients, shape [quads, points, n, 3].
        weights: reference volumes, shape [quads, points].
        psi: pressure functions, shape [quads, points, q].
        functions, centre: psi_m and c_am of the incompatible modes, shapes [quads, points, k] and [n, k].
        compliance_inv: G^-1, shape [quads, q, q].
        mu: shear modulus.
        p: element pressures, shape [slices, quads, q].
        inner: incompatible modes, shape [slices, quads, k, 3].
        residual: added to, shape [nodes, 3].
        tangent: whether the matrix values `data` are added to as well.
        data, slots, node_ptr, upper: the matrix, see `Pattern`.
        b_out, R_out: kept for the pressure update, shapes [slices, quads, q, 3 (n + k)] and [slices, quads, q].
        follow_out: of the modes, see `_condense_modes`, shape [slices, quads, 3 k, 3 n + 1].

    Returns:
        Smallest determinant of the deformation gradient.
    """
    slices, quads, count = elements.shape
    points = weights.shape[1]
    modes = psi.shape[2]
    extra = inner.shape[2]
    whole = count + extra
    stiff = tangent or extra > 0
    worst = np.full(slices, np.inf)
    for colour in range(2):
        for pair in prange((slices + 1 - colour) // 2):
            layer = 2 * pair + colour
            F = np.empty((3, 3))
            y = np.empty((count, 3))
            t = np.empty((extra, 3))
            along = np.empty((3, extra))
            enhanced = np.empty((count, 3))
            inv = np.empty((3, 3))
            s = np.empty((3, 3))
            g = np.empty((3, whole))
            sg = np.empty((3, whole))
            f = np.empty((3, whole))
            K = np.empty((3, 3, whole, whole))
            b = np.empty((modes, 3, whole))
            R = np.empty(modes)
            total = np.empty(modes)
            A = np.empty((3 * extra, 3 * extra))
            for e in range(quads):
                nodes = elements[layer, e]
                f[:] = 0.0
                b[:] = 0.0
                R[:] = 0.0
                gather(x, nodes, y)
                tangents(y, centre, t)
                if stiff:
                    K[:] = 0.0
                for q in range(points):
                    grad = grads[e, q]
                    w = weights[e, q]
                    if extra > 0:
                        enhance(grad, functions[e, q], centre, inner[layer, e], enhanced)
                        grad = enhanced
                    J = deformation(y, grad, F)
                    worst[layer] = min(worst[layer], J)
                    inverse(F, J, inv)
                    trace = deviator(F, mu * w * abs(J) ** (-2.0 / 3.0), s)
                    mu_bar = mu * w * abs(J) ** (-2.0 / 3.0) * trace / 3.0
                    pressure = 0.0
                    for m in range(modes):
                        pressure += psi[e, q, m] * p[layer, e, m]
                        R[m] += psi[e, q, m] * w * (J - 1.0)
                    for a in range(count):
                        for i in range(3):
                            g[i, a] = grad[a, 0] * inv[0, i] + grad[a, 1] * inv[1, i] + grad[a, 2] * inv[2, i]
                        for i in range(3):
                            sg[i, a] = s[i, 0] * g[0, a] + s[i, 1] * g[1, a] + s[i, 2] * g[2, a]
                            f[i, a] += sg[i, a]
                            for m in range(modes):
                                b[m, i, a] += psi[e, q, m] * w * J * g[i, a]
                    if stiff:
                        _point_tangent(g, sg, count, mu_bar, pressure * w * J, K)
                    if extra > 0:
                        _point_modes(
                            count, t, functions[e, q], centre, inv, s, g, sg, mu_bar, pressure * w * J, f, K, along
                        )
                        for m in range(modes):
                            for k in range(extra):
                                for i in range(3):
                                    b[m, i, count + k] += psi[e, q, m] * w * J * along[i, k]
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
                        for a in range(whole):
                            f[i, a] += total[m] * b[m, i, a]
                            b_out[layer, e, m, 3 * a + i] = b[m, i, a]
                if stiff:
                    for m in range(modes):
                        g[:] = 0.0
                        for k in range(modes):
                            c = compliance_inv[e, m, k]
                            for j in range(3):
                                for d in range(whole):
                                    g[j, d] += c * b[k, j, d]
                        for i in range(3):
                            for j in range(3):
                                for a in range(whole):
                                    cb = b[m, i, a]
                                    for d in range(whole):
                                        K[i, j, a, d] += cb * g[j, d]
                if extra > 0:
                    _condense_modes(count, f, K, A, follow_out[layer, e])
                for a in range(count):
                    for i in range(3):
                        residual[nodes[a], i] += f[i, a]
                if not tangent:
                    continue
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


@kernel(parallel=True)
def mode_increment(du, elements, follow, change):
    """change = -A^-1 (f_beta + K_beta,x du) of the incompatible modes, shape [slices, quads, k, 3]."""
    slices, quads, count = elements.shape
    for layer in prange(slices):
        for e in range(quads):
            for r in range(follow.shape[2]):
                value = follow[layer, e, r, 3 * count]
                for a in range(count):
                    node = elements[layer, e, a]
                    for i in range(3):
                        value += follow[layer, e, r, 3 * a + i] * du[node, i]
                change[layer, e, r // 3, r % 3] = -value


@kernel(parallel=True)
def pressure_increment(du, elements, modes_change, compliance_inv, b, excess, dp):
    """dp = G^-1 (R + b . du), with `excess` = G^-1 R; shapes as in `assemble`."""
    slices, quads, count = elements.shape
    extra, modes = modes_change.shape[2], dp.shape[2]
    for layer in prange(slices):
        y = np.empty((count + extra, 3))
        change = np.empty(modes)
        for e in range(quads):
            gather(du, elements[layer, e], y)
            y[count:] = modes_change[layer, e]
            for m in range(modes):
                value = 0.0
                for a in range(count + extra):
                    for i in range(3):
                        value += b[layer, e, m, 3 * a + i] * y[a, i]
                change[m] = value
            for m in range(modes):
                value = excess[layer, e, m]
                for k in range(modes):
                    value += compliance_inv[e, m, k] * change[k]
                dp[layer, e, m] = value


@kernel(parallel=True, error_model="numpy")
def merit(x, inner, elements, grads, weights, psi, functions, centre, mu, p, modulus):
    """Sum of W_dev + p (J - 1) + modulus/2 (theta - 1)^2 and the smallest J.

    The augmented Lagrangian of the mixed element with a moderate modulus; modulus = 0 with the converged pressure
    leaves W_dev + p (theta - 1). Shapes as in `assemble`.
    """
    slices, quads, count = elements.shape
    points = weights.shape[1]
    modes, extra = psi.shape[2], inner.shape[2]
    sums = np.zeros(slices)
    worst = np.full(slices, np.inf)
    for layer in prange(slices):
        F = np.empty((3, 3))
        y = np.empty((count, 3))
        enhanced = np.empty((count, 3))
        value = 0.0
        for e in range(quads):
            gather(x, elements[layer, e], y)
            volume = 0.0
            dilatation = 0.0
            for q in range(points):
                w = weights[e, q]
                grad = grads[e, q]
                if extra > 0:
                    enhance(grad, functions[e, q], centre, inner[layer, e], enhanced)
                    grad = enhanced
                J = deformation(y, grad, F)
                worst[layer] = min(worst[layer], J)
                trace = 0.0
                for i in range(3):
                    for k in range(3):
                        trace += F[i, k] * F[i, k]
                pressure = 0.0
                for m in range(modes):
                    pressure += psi[e, q, m] * p[layer, e, m]
                value += w * (0.5 * mu * (abs(J) ** (-2.0 / 3.0) * trace - 3.0) + pressure * (J - 1.0))
                volume += w
                dilatation += w * (J - 1.0)
            value += 0.5 * modulus * dilatation * dilatation / volume
        sums[layer] = value
    return sums.sum(), worst.min() if slices > 0 else np.inf
