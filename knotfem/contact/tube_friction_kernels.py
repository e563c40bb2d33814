"""Compiled loops of Coulomb friction between tubes.

The anchor of a pair is a material point of the master surface. With q = p - S(anchor), the slip is
e = (I - n n^T) q and the traction T = mu N psi(|e| / stick) e / |e|, where n and N belong to the closest point. Its
tangent is complete:

    d e = (I - n n^T) dq - dn (n . q) - n (q . dn)
    d n = S^a (B_a^T n - kappa_ab dxi^b)           d xi = H^-1 (B^T S - g B_d^T n)
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.penalty import mobilisation, mobilisation_energy, penalty
from knotfem.contact.tube import dot, stencil, surface_point
from knotfem.contact.tube_contact_kernels import normal, pair_geometry
from knotfem.sparse.pattern import block_slot, row_start


@kernel(error_model="numpy")
def slip_vector(x, tubes, p, rod, anchor, n, W, S, nodes, q, e):
    """Slip e (3) of a pair from its anchor; fills the anchor's stencil; returns |e|."""
    stencil(tubes, rod, anchor[0], anchor[1], nodes, W)
    surface_point(x, nodes, W, S)
    for i in range(3):
        q[i] = p[i] - S[0, i]
    along = dot(n, q)
    for i in range(3):
        e[i] = q[i] - along * n[i]
    return np.sqrt(dot(e, e))


@kernel(inline="always", error_model="numpy")
def _normal_rate(B, Bd, forms, S, n, g, column, dn):
    """Derivative (3, 3) of the normal with respect to one node of the pair."""
    a11, a12, a22 = forms[0, 0], forms[0, 1], forms[0, 2]
    det = a11 * a22 - a12 * a12
    for j in range(3):
        c1 = B[column] * S[1, j] - g * Bd[0, column] * n[j]
        c2 = B[column] * S[2, j] - g * Bd[1, column] * n[j]
        xi1 = forms[2, 0] * c1 + forms[2, 1] * c2
        xi2 = forms[2, 1] * c1 + forms[2, 2] * c2
        y1 = Bd[0, column] * n[j] - forms[1, 0] * xi1 - forms[1, 1] * xi2
        y2 = Bd[1, column] * n[j] - forms[1, 1] * xi1 - forms[1, 2] * xi2
        z1, z2 = (a22 * y1 - a12 * y2) / det, (a11 * y2 - a12 * y1) / det
        for i in range(3):
            dn[i, j] = S[1, i] * z1 + S[2, i] * z2


@kernel(error_model="numpy")
def assemble(
    x, tubes, sample_nodes, sample_weights, area, points, pairs, uv, gap, share, friction, stiffness, ramp, stick,
    anchors, residual, tangent, data, node_ptr, node_adj, upper, slip, traction,
):  # fmt: skip
    """Residual and tangent of the friction of all pairs.

    Args:
        friction: coefficient of each pair, shape [pairs].
        anchors: parameters of the anchors, shape [pairs, 2].
        slip: |e| of each pair in contact, filled, shape [pairs].
        traction: friction force on the slave, filled, shape [pairs, 3].

    Returns:
        False where a block lies outside the pattern.
    """
    W, S = np.empty((6, 12)), np.empty((6, 3))
    Wa, Sa, anchor_nodes = np.empty((6, 12)), np.empty((6, 3)), np.empty(12, np.int64)
    q, n, B, Bd, forms = np.empty(3), np.empty(3), np.empty(24), np.empty((2, 24)), np.empty((3, 3))
    nodes, columns, rows = np.empty(24, np.int64), np.empty(36, np.int64), np.empty(24, np.int64)
    qa, e, T = np.empty(3), np.empty(3), np.empty(3)
    R = np.empty(24)
    dn, de, D, M = np.empty((3, 3)), np.empty((3, 3)), np.empty((36, 3, 3)), np.empty((3, 3))
    for k in range(pairs.shape[0]):
        slip[k] = 0.0
        for i in range(3):
            traction[k, i] = 0.0
        s, rod = pairs[k, 0], pairs[k, 1]
        _, pressure, slope = penalty(gap[k], stiffness, ramp)
        if pressure == 0.0 or friction[k] == 0.0:
            continue
        w = area[s] * share[k]
        g = pair_geometry(
            x, tubes, points[s], rod, uv[k, 0], uv[k, 1], sample_nodes[s], sample_weights[s], W, S, q, n, nodes, B, Bd,
            forms,
        )  # fmt: skip
        size = slip_vector(x, tubes, points[s], rod, anchors[k], n, Wa, Sa, anchor_nodes, qa, e)
        slip[k] = size
        _, psi_y, dpsi = mobilisation(size / stick)
        limit = friction[k] * w * pressure
        for i in range(3):
            T[i] = limit * psi_y / stick * e[i]
            traction[k, i] = -T[i]
        for a in range(12):
            for i in range(3):
                residual[nodes[a], i] += B[a] * T[i]
                residual[anchor_nodes[a], i] -= Wa[0, a] * T[i]
        if not tangent:
            continue
        # M = limit (dpsi/stick ee + psi_y/stick (I - ee)) in the direction e / |e|
        inverse = 1.0 / size if size > 0.0 else 0.0
        for i in range(3):
            for j in range(3):
                ee = e[i] * e[j] * inverse * inverse
                M[i, j] = limit / stick * ((dpsi - psi_y) * ee + (psi_y if i == j else 0.0))
        along = dot(n, qa)
        for c in range(36):
            columns[c] = nodes[c] if c < 24 else anchor_nodes[c - 24]
            if c < 24:
                _normal_rate(B, Bd, forms, S, n, g, c, dn)
            else:
                dn[:] = 0.0
            own = B[c] if c < 12 else (-Wa[0, c - 24] if c >= 24 else 0.0)
            for j in range(3):
                qdn = qa[0] * dn[0, j] + qa[1] * dn[1, j] + qa[2] * dn[2, j]
                for i in range(3):
                    de[i, j] = own * ((1.0 if i == j else 0.0) - n[i] * n[j]) - along * dn[i, j] - n[i] * qdn
            for i in range(3):
                lost = friction[k] * w * slope * psi_y / stick * e[i]
                for j in range(3):
                    D[c, i, j] = M[i, 0] * de[0, j] + M[i, 1] * de[1, j] + M[i, 2] * de[2, j]
                    if c < 24:
                        D[c, i, j] -= lost * B[c] * n[j]
        for a in range(24):
            rows[a] = nodes[a] if a < 12 else anchor_nodes[a - 12]
            R[a] = B[a] if a < 12 else -Wa[0, a - 12]
        for a in range(24):
            for c in range(36):
                if upper and columns[c] < rows[a]:
                    continue
                slot = block_slot(node_ptr, node_adj, rows[a], columns[c])
                if slot < 0:
                    return False
                for i in range(3):
                    start = row_start(node_ptr, upper, rows[a], i) + 3 * slot
                    for j in range(3):
                        if upper and rows[a] == columns[c] and j < i:
                            continue
                        data[start + j] += R[a] * D[c, i, j]
    return True


@kernel
def potential(x, tubes, points, pairs, uv, force, friction, stick, anchors):
    """Friction potential with the given normal forces (lagged), for the line search."""
    W, S = np.empty((6, 12)), np.empty((6, 3))
    nodes, q, e, n = np.empty(12, np.int64), np.empty(3), np.empty(3), np.empty(3)
    total = 0.0
    for k in range(pairs.shape[0]):
        if force[k] == 0.0:
            continue
        s, rod = pairs[k, 0], pairs[k, 1]
        pair_normal(x, tubes, rod, uv[k], W, S, nodes, n)
        size = slip_vector(x, tubes, points[s], rod, anchors[k], n, W, S, nodes, q, e)
        total += friction[k] * force[k] * stick * mobilisation_energy(size / stick)
    return total


@kernel
def stray_stencils(tubes, sample_nodes, pairs, uv, gap, reach, pad, anchors, out):
    """Slave, master and anchor nodes (36) of near pairs whose anchor has left the padded patch; returns how many."""
    W, nodes = np.empty((6, 12)), np.empty(12, np.int64)
    count = 0
    for k in range(pairs.shape[0]):
        rod = pairs[k, 1]
        around = tubes[2][rod]
        turn = np.floor(anchors[k, 1] + 0.5) - np.floor(uv[k, 1] + 0.5)
        turn -= around * np.round(turn / around)
        along = np.floor(anchors[k, 0] + 0.5) - np.floor(uv[k, 0] + 0.5)
        if gap[k] > reach or (abs(along) <= pad and abs(turn) <= pad):
            continue
        stencil(tubes, rod, uv[k, 0], uv[k, 1], nodes, W)
        for a in range(12):
            out[count, a] = sample_nodes[pairs[k, 0], a]
            out[count, 12 + a] = nodes[a]
        stencil(tubes, rod, anchors[k, 0], anchors[k, 1], nodes, W)
        for a in range(12):
            out[count, 24 + a] = nodes[a]
        count += 1
    return count


@kernel
def pair_normal(x, tubes, rod, uv, W, S, nodes, n):
    """Unit normal of a tube at (u, v)."""
    stencil(tubes, rod, uv[0], uv[1], nodes, W)
    surface_point(x, nodes, W, S)
    normal(S, n)


@kernel
def drag_anchors(uv, force, slip, stick, around, pairs, anchors):
    """Commit: sliding anchors follow at the stick distance, those of pairs that do not rub (`force` 0) all the way."""
    for k in range(pairs.shape[0]):
        if force[k] == 0.0:
            anchors[k, 0], anchors[k, 1] = uv[k, 0], uv[k, 1]
        elif slip[k] > stick:
            share = stick / slip[k]
            period = around[pairs[k, 1]]
            turn = anchors[k, 1] - uv[k, 1]
            turn -= period * np.round(turn / period)
            anchors[k, 0] = uv[k, 0] + share * (anchors[k, 0] - uv[k, 0])
            anchors[k, 1] = uv[k, 1] + share * turn
