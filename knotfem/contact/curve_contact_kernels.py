"""Compiled loops of contact between strands.

A sample p = b(s) of one strand meets the closest point a(u) of another's smooth curve: q = p - a, n = q/|q|,
gap = |q| - r_s - r_m. With N the curve's basis, B = [N_s, -N_m], B' = [0, -N_m'] over the three nodes of each, and
h = a' . a' - q . a'',

    du       = [(a' . dp_B) - (q . dp_B')]/h          with dp_B = sum B dx, dp_B' = sum B' dx
    grad gap = B n
    dn       = [(I - n n^T) dp_B - a' du]/|q|
    Hess gap = B dn + B' n du
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.curve import curve_point, project
from knotfem.contact.penalty import penalty
from knotfem.geometry.rotation import dot
from knotfem.sparse.rod_pattern import add_blocks

WIDE_BEND = 0.5
"""Relative difference of the strands' bends towards each other beyond which one of them carries all samples."""
CUP = (0.05, 0.25)
"""A point this near (relative to |q|) to the centre of the other strand's bend has no closest point to speak of."""


@kernel
def project_pairs(x, first, radius, sample_rod, points, pairs, u, gap):
    """Closest points and gaps of known pairs from where they were; a gap of inf where there is none any more."""
    w, C, q = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        start = u[k]
        found, _, inside = project(x, first[rod], first[rod + 1] - first[rod], points[s], start, w, C, q)
        if inside:
            u[k] = found
            gap[k] = np.sqrt(dot(q, q)) - radius[rod] - radius[sample_rod[s]]
        else:
            gap[k] = np.inf


@kernel(inline="always")
def smooth_step(y):
    y = min(max(y, 0.0), 1.0)
    return y * y * (3.0 - 2.0 * y)


@kernel
def pair_shares(x, first, sample_base, sample_weights, points, pairs, u, share):
    """Share of each pair's sample length that it carries: of the two passes over a contact the better one more.

    Where one strand bends round the other, the bent one's samples see a well-defined closest point, while a sample of
    the straight one sits near the centre of the bend. With c_m = 1 - q . a''/a'^2 and c_s the like for the slave, the
    share goes smoothly from 0 to 1 with (c_m - c_s)/(c_m + c_s); those of the two passes add up to 1. It fades where
    the closest point leaves the master's end.
    """
    w, C, q, D = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        count = first[rod + 1] - first[rod]
        found, _, inside = project(x, first[rod], count, points[s], u[k], w, C, q)
        if not inside:
            share[k] = 0.0
            continue
        curve_point(x, sample_base[s], sample_weights[s], D)
        own = max(1.0 - dot(q, C[2]) / dot(C[1], C[1]), 0.0)
        other = max(1.0 + dot(q, D[2]) / dot(D[1], D[1]), 0.0)
        lean = (own - other) / max(own + other, 1e-300)
        share[k] = smooth_step(0.5 + 0.5 * lean / WIDE_BEND) * smooth_step((own - CUP[0]) / (CUP[1] - CUP[0]))
        share[k] *= min(max(1.0 + min(found, count - 1.0 - found), 0.0), 1.0)


@kernel
def pair_geometry(x, first, count, point, u, sample_base, sample_weights, w, C, q, n, nodes, B, Bd):
    """Closest-point data of a pair: nodes (6), B (6), B' (6), n; returns |q|, h and the first master node."""
    _, base, _ = project(x, first, count, point, u, w, C, q)
    size = np.sqrt(dot(q, q))
    for i in range(3):
        n[i] = q[i] / size
        nodes[i], nodes[3 + i] = sample_base + i, base + i
        B[i], B[3 + i] = sample_weights[0, i], -w[0, i]
        Bd[i], Bd[3 + i] = 0.0, -w[1, i]
    return size, dot(C[1], C[1]) - dot(q, C[2]), base


@kernel(inline="always")
def normal_rate(B, Bd, n, size, slope, h, dn):
    """Derivative (3, 3) of the normal by the place of one node; `slope` is a'."""
    for i in range(3):
        for j in range(3):
            du = (B * slope[j] - Bd * size * n[j]) / h
            dn[i, j] = (B * ((1.0 if i == j else 0.0) - n[i] * n[j]) - slope[i] * du) / size


@kernel
def assemble(
    x, first, sample_base, sample_weights, length, points, pairs, u, gap, share, stiffness, ramp,
    residual, tangent, node_ptr, node_adj, data, force,
):  # fmt: skip
    """Residual and tangent of the normal contact of all pairs; `force` (pairs) is filled. False outside the pattern."""
    w, C, q, n = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    nodes, B, Bd, dn = np.empty(6, np.int64), np.empty(6), np.empty(6), np.empty((3, 3))
    block = np.zeros((24, 24))
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        _, pressure, slope = penalty(gap[k], stiffness, ramp)
        weight = length[s] * share[k]
        force[k] = weight * pressure
        if force[k] == 0.0:
            continue
        size, h, _ = pair_geometry(
            x, first[rod], first[rod + 1] - first[rod], points[s], u[k], sample_base[s], sample_weights[s], w, C, q, n,
            nodes, B, Bd,
        )  # fmt: skip
        for a in range(6):
            for i in range(3):
                residual[nodes[a], i] -= force[k] * B[a] * n[i]
        if not tangent:
            continue
        for c in range(6):
            normal_rate(B[c], Bd[c], n, size, C[1], h, dn)
            for a in range(6):
                for i in range(3):
                    for j in range(3):
                        du = (B[c] * C[1, j] - Bd[c] * size * n[j]) / h
                        bent = B[a] * dn[i, j] + Bd[a] * n[i] * du
                        block[4 * a + i, 4 * c + j] = weight * slope * B[a] * n[i] * B[c] * n[j] - force[k] * bent
        if not add_blocks(nodes, nodes, block, node_ptr, node_adj, data):
            return False
    return True


@kernel
def energy(length, pairs, gap, share, stiffness, ramp):
    """Stored energy of all pairs."""
    total = 0.0
    for k in range(pairs.shape[0]):
        total += length[pairs[k, 0]] * share[k] * penalty(gap[k], stiffness, ramp)[0]
    return total


@kernel
def pattern_stencils(first, sample_base, pairs, u, gap, anchor_u, reach, pad, out):
    """Nodes that each near pair couples: the sample's 3, the master's padded 3 + 2 pad, the anchor's 3; -1 unused."""
    count = 0
    wide = 3 + 2 * pad
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        if not gap[k] < reach:
            continue
        nodes = first[rod + 1] - first[rod]
        for a in range(3):
            out[count, a] = sample_base[s] + a
        middle = _middle(u[k], nodes)
        for a in range(wide):
            j = middle - 1 - pad + a
            out[count, 3 + a] = first[rod] + j if 0 <= j < nodes else -1
        middle = _middle(anchor_u[k], nodes)
        for a in range(3):
            out[count, 3 + wide + a] = first[rod] + middle - 1 + a
        count += 1
    return count


@kernel(inline="always")
def _middle(u, nodes):
    return min(max(int(np.floor(u + 0.5)), 1), nodes - 2)
