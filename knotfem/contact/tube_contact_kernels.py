"""Compiled loops of normal contact between tubes.

With q = p - S normal to the surface, metric A, curvature kappa_ab = n . S_ab, H = A - g kappa, and the shape functions
of slave and master in B = [N_s, -N_m], B_a = [0, -N_m,a]:

    grad g = B^T n
    Hess g = -(B^T S_a)(A^-1 kappa H^-1)^ab (B^T S_b)^T + [(B^T S_a) H^ab (B_b^T n)^T + transpose]
             - g (B_a^T n) H^ab (B_b^T n)^T
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.penalty import penalty
from knotfem.contact.tube import dot, project, stencil, surface_point
from knotfem.sparse.pattern import block_slot, row_start


@kernel
def project_pairs(x, tubes, points, pairs, uv, gap):
    """Closest points of all pairs: `uv` is updated in place, `gap` filled (infinite beyond a rod's ends)."""
    W, S = np.empty((6, 12)), np.empty((6, 3))
    nodes, q, n = np.empty(12, np.int64), np.empty(3), np.empty(3)
    for k in range(pairs.shape[0]):
        s, rod = pairs[k, 0], pairs[k, 1]
        u, v, inside = project(x, tubes, rod, points[s], uv[k, 0], uv[k, 1], W, nodes, S, q)
        uv[k, 0], uv[k, 1] = u, v
        if inside:
            normal(S, n)
            gap[k] = dot(q, n)
        else:
            gap[k] = np.inf


@kernel(inline="always")
def normal(S, n):
    """Outward unit normal S_v x S_u."""
    n[0] = S[2, 1] * S[1, 2] - S[2, 2] * S[1, 1]
    n[1] = S[2, 2] * S[1, 0] - S[2, 0] * S[1, 2]
    n[2] = S[2, 0] * S[1, 1] - S[2, 1] * S[1, 0]
    size = np.sqrt(dot(n, n))
    for i in range(3):
        n[i] /= size


@kernel
def pair_geometry(x, tubes, p, rod, u, v, sample_nodes, sample_weights, W, S, q, n, nodes, B, Bd, forms):
    """Stencil and forms of one pair at its closest point.

    Args:
        nodes: slave then master nodes, shape [24].
        B, Bd: shape functions of the gap and of its two tangents, shapes [24] and [2, 24].
        forms: A (3), kappa (3), H^-1 (3), each as 11, 12, 22; shape [3, 3].

    Returns:
        Signed distance n . q.
    """
    stencil(tubes, rod, u, v, nodes[12:], W)
    surface_point(x, nodes[12:], W, S)
    for i in range(3):
        q[i] = p[i] - S[0, i]
    normal(S, n)
    g = dot(q, n)
    for a in range(12):
        nodes[a] = sample_nodes[a]
        B[a], Bd[0, a], Bd[1, a] = sample_weights[a], 0.0, 0.0
        B[12 + a], Bd[0, 12 + a], Bd[1, 12 + a] = -W[0, a], -W[1, a], -W[2, a]
    forms[0, 0], forms[0, 1], forms[0, 2] = dot(S[1], S[1]), dot(S[1], S[2]), dot(S[2], S[2])
    forms[1, 0], forms[1, 1], forms[1, 2] = dot(n, S[3]), dot(n, S[4]), dot(n, S[5])
    h11 = forms[0, 0] - g * forms[1, 0]
    h12 = forms[0, 1] - g * forms[1, 1]
    h22 = forms[0, 2] - g * forms[1, 2]
    det = h11 * h22 - h12 * h12
    forms[2, 0], forms[2, 1], forms[2, 2] = h22 / det, -h12 / det, h11 / det
    return g


@kernel
def _hessian_coefficients(forms, S, n, g, slope, pressure, T0, T1, T2):
    """Blocks of w (P' grad g grad g - P Hess g): T0 (3, 3), T1 (2, 3, 3), T2 (2, 2)."""
    a11, a12, a22 = forms[0, 0], forms[0, 1], forms[0, 2]
    det = a11 * a22 - a12 * a12
    inv11, inv12, inv22 = a22 / det, -a12 / det, a11 / det
    k11, k12, k22 = forms[1, 0], forms[1, 1], forms[1, 2]
    h11, h12, h22 = forms[2, 0], forms[2, 1], forms[2, 2]
    m11, m12 = inv11 * k11 + inv12 * k12, inv11 * k12 + inv12 * k22
    m21, m22 = inv12 * k11 + inv22 * k12, inv12 * k12 + inv22 * k22
    c11, c12 = m11 * h11 + m12 * h12, m11 * h12 + m12 * h22
    c21, c22 = m21 * h11 + m22 * h12, m21 * h12 + m22 * h22
    c12 = 0.5 * (c12 + c21)
    for i in range(3):
        for j in range(3):
            curved = c11 * S[1, i] * S[1, j] + c22 * S[2, i] * S[2, j] + c12 * (S[1, i] * S[2, j] + S[2, i] * S[1, j])
            T0[i, j] = slope * n[i] * n[j] + pressure * curved
            T1[0, i, j] = -pressure * (S[1, i] * h11 + S[2, i] * h12) * n[j]
            T1[1, i, j] = -pressure * (S[1, i] * h12 + S[2, i] * h22) * n[j]
    T2[0, 0], T2[0, 1], T2[1, 0], T2[1, 1] = (
        pressure * g * h11,
        pressure * g * h12,
        pressure * g * h12,
        pressure * g * h22,
    )


@kernel(error_model="numpy")
def assemble(
    x, tubes, sample_nodes, sample_weights, area, points, pairs, uv, gap, share, stiffness, ramp,
    residual, tangent, data, node_ptr, node_adj, upper, force,
):  # fmt: skip
    """Residual and tangent of the normal contact of all pairs.

    Args:
        share: factor on each pair's area, shape [pairs].
        force: normal force of each pair, filled, shape [pairs].

    Returns:
        False where a block lies outside the pattern.
    """
    W, S = np.empty((6, 12)), np.empty((6, 3))
    q, n, B, Bd, forms = np.empty(3), np.empty(3), np.empty(24), np.empty((2, 24)), np.empty((3, 3))
    nodes = np.empty(24, np.int64)
    T0, T1, T2 = np.empty((3, 3)), np.empty((2, 3, 3)), np.empty((2, 2))
    for k in range(pairs.shape[0]):
        s, rod = pairs[k, 0], pairs[k, 1]
        _, pressure, slope = penalty(gap[k], stiffness, ramp)
        w = area[s] * share[k]
        force[k] = w * pressure
        if pressure == 0.0:
            continue
        g = pair_geometry(
            x, tubes, points[s], rod, uv[k, 0], uv[k, 1], sample_nodes[s], sample_weights[s], W, S, q, n, nodes, B, Bd,
            forms,
        )  # fmt: skip
        for a in range(24):
            for i in range(3):
                residual[nodes[a], i] -= w * pressure * B[a] * n[i]
        if not tangent:
            continue
        _hessian_coefficients(forms, S, n, g, w * slope, w * pressure, T0, T1, T2)
        for a in range(24):
            for b in range(24):
                if upper and nodes[b] < nodes[a]:
                    continue
                slot = block_slot(node_ptr, node_adj, nodes[a], nodes[b])
                if slot < 0:
                    return False
                bb = B[a] * B[b]
                b0, b1 = B[a] * Bd[0, b], B[a] * Bd[1, b]
                d0, d1 = Bd[0, a] * B[b], Bd[1, a] * B[b]
                nn = (
                    Bd[0, a] * (T2[0, 0] * Bd[0, b] + T2[0, 1] * Bd[1, b])
                    + Bd[1, a] * (T2[1, 0] * Bd[0, b] + T2[1, 1] * Bd[1, b])
                )  # fmt: skip
                for i in range(3):
                    start = row_start(node_ptr, upper, nodes[a], i) + 3 * slot
                    for j in range(3):
                        if upper and nodes[a] == nodes[b] and j < i:
                            continue
                        data[start + j] += (
                            bb * T0[i, j]
                            + b0 * T1[0, i, j]
                            + b1 * T1[1, i, j]
                            + d0 * T1[0, j, i]
                            + d1 * T1[1, j, i]
                            + nn * n[i] * n[j]
                        )
    return True


@kernel
def energy(area, pairs, gap, share, stiffness, ramp):
    """Stored energy of all pairs."""
    total = 0.0
    for k in range(pairs.shape[0]):
        total += area[pairs[k, 0]] * share[k] * penalty(gap[k], stiffness, ramp)[0]
    return total


@kernel
def patches(tubes, pairs, uv, gap, reach, sample_u, sample_v, sample_rod, out):
    """Slave and master patch of each near pair: rods, first sections and middle nodes; returns how many."""
    around, sections = tubes[2], tubes[3]
    n = 0
    for k in range(pairs.shape[0]):
        if gap[k] > reach:
            continue
        s, rod = pairs[k, 0], pairs[k, 1]
        slave = sample_rod[s]
        out[n, 0] = slave
        out[n, 1] = min(max(int(np.floor(sample_u[s] + 0.5)), 1), sections[slave] - 2)
        out[n, 2] = int(np.floor(sample_v[s] + 0.5)) % around[slave]
        out[n, 3] = rod
        out[n, 4] = min(max(int(np.floor(uv[k, 0] + 0.5)), 1), sections[rod] - 2)
        out[n, 5] = int(np.floor(uv[k, 1] + 0.5)) % around[rod]
        n += 1
    return n


@kernel
def patch_keys(tubes, patch, pad, count, out):
    """Adjacency keys of slave patches (3 x 3 nodes) with master patches padded by `pad`, into out (unsorted)."""
    ring, ring_start, around, sections, axis, axis_start, _ = tubes
    wide = 3 + 2 * pad
    nodes = np.empty(12 + wide * (wide + 1), np.int64)
    n = 0
    for k in range(patch.shape[0]):
        size = 0
        for side in range(2):
            rod, middle, angle = patch[k, 3 * side], patch[k, 3 * side + 1], patch[k, 3 * side + 2]
            extra = 1 + (pad if side == 1 else 0)
            m = around[rod]
            for a in range(-extra, extra + 1):
                row = middle + a
                if row < 0 or row >= sections[rod]:
                    continue
                for b in range(-extra, min(extra, m - 1 - extra) + 1):
                    nodes[size] = ring[ring_start[rod] + row * m + (angle + b + m) % m]
                    size += 1
                nodes[size] = axis[axis_start[rod] + row]
                size += 1
        for a in range(size):
            for b in range(size):
                out[n] = nodes[a] * count + nodes[b]
                n += 1
    return n
