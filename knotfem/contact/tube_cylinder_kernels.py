"""Compiled loops of contact and friction between tubes and a rigid cylinder.

A sample p at distance rho from the axis has the gap g = rho - R, grad g = n (radial) and
Hess g = (I - n n^T - a a^T) / rho, which is also the derivative of n.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.penalty import mobilisation, mobilisation_energy, penalty
from knotfem.contact.tube import dot
from knotfem.sparse.pattern import block_slot, row_start


@kernel(inline="always", error_model="numpy")
def radial(p, origin, axis, n):
    """Distance of p from the axis; n (3) is the outward unit vector."""
    along = 0.0
    for i in range(3):
        along += (p[i] - origin[i]) * axis[i]
    for i in range(3):
        n[i] = p[i] - origin[i] - along * axis[i]
    rho = np.sqrt(dot(n, n))
    for i in range(3):
        n[i] /= rho
    return rho


@kernel
def gaps(points, origin, axis, radius, candidates, gap, limit):
    """Samples with a gap below `limit` into `candidates`, and their gaps; returns how many."""
    n = np.empty(3)
    count = 0
    for s in range(points.shape[0]):
        g = radial(points[s], origin, axis, n) - radius
        if g < limit:
            candidates[count], gap[count] = s, g
            count += 1
    return count


@kernel(inline="always", error_model="numpy")
def _scatter(nodes, weights, block, node_ptr, node_adj, upper, data):
    for a in range(nodes.size):
        for b in range(nodes.size):
            if upper and nodes[b] < nodes[a]:
                continue
            slot = block_slot(node_ptr, node_adj, nodes[a], nodes[b])
            if slot < 0:
                return False
            for i in range(3):
                start = row_start(node_ptr, upper, nodes[a], i) + 3 * slot
                for j in range(3):
                    if upper and nodes[a] == nodes[b] and j < i:
                        continue
                    data[start + j] += weights[a] * weights[b] * block[i, j]
    return True


@kernel(error_model="numpy")
def assemble(
    sample_nodes, sample_weights, area, points, touching, origin, axis, radius, stiffness, ramp, residual, tangent,
    data, node_ptr, node_adj, upper, force,
):  # fmt: skip
    """Normal contact of the samples in `touching`; `force` (samples) is filled. False outside the pattern."""
    n, block = np.empty(3), np.empty((3, 3))
    for k in range(touching.size):
        s = touching[k]
        rho = radial(points[s], origin, axis, n)
        _, pressure, slope = penalty(rho - radius, stiffness, ramp)
        w = area[s]
        force[s] = w * pressure
        if pressure == 0.0:
            continue
        for a in range(12):
            for i in range(3):
                residual[sample_nodes[s, a], i] -= w * pressure * sample_weights[s, a] * n[i]
        if not tangent:
            continue
        for i in range(3):
            for j in range(3):
                turn = ((1.0 if i == j else 0.0) - n[i] * n[j] - axis[i] * axis[j]) / rho
                block[i, j] = w * (slope * n[i] * n[j] - pressure * turn)
        if not _scatter(sample_nodes[s], sample_weights[s], block, node_ptr, node_adj, upper, data):
            return False
    return True


@kernel(error_model="numpy")
def assemble_friction(
    sample_nodes, sample_weights, area, points, touching, origin, axis, radius, stiffness, ramp, friction, stick,
    anchors, residual, tangent, data, node_ptr, node_adj, upper, slip, traction,
):  # fmt: skip
    """Friction of the samples in `touching` from their anchors on the cylinder (samples, 3)."""
    n, q, e = np.empty(3), np.empty(3), np.empty(3)
    dn, M, block = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    for k in range(touching.size):
        s = touching[k]
        slip[s] = 0.0
        traction[s] = 0.0
        rho = radial(points[s], origin, axis, n)
        _, pressure, slope = penalty(rho - radius, stiffness, ramp)
        if pressure == 0.0 or friction[s] == 0.0:
            continue
        for i in range(3):
            q[i] = points[s, i] - anchors[s, i]
        along = dot(n, q)
        for i in range(3):
            e[i] = q[i] - along * n[i]
        size = np.sqrt(dot(e, e))
        slip[s] = size
        _, psi_y, dpsi = mobilisation(size / stick)
        limit = friction[s] * area[s] * pressure
        for i in range(3):
            traction[s, i] = -limit * psi_y / stick * e[i]
        for a in range(12):
            for i in range(3):
                residual[sample_nodes[s, a], i] -= sample_weights[s, a] * traction[s, i]
        if not tangent:
            continue
        inverse = 1.0 / size if size > 0.0 else 0.0
        for i in range(3):
            for j in range(3):
                ee = e[i] * e[j] * inverse * inverse
                M[i, j] = limit / stick * ((dpsi - psi_y) * ee + (psi_y if i == j else 0.0))
                dn[i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j] - axis[i] * axis[j]) / rho
        for i in range(3):
            lost = friction[s] * area[s] * slope * psi_y / stick * e[i]
            for j in range(3):
                value = -lost * n[j]
                for m in range(3):
                    qdn = q[0] * dn[0, j] + q[1] * dn[1, j] + q[2] * dn[2, j]
                    de = (1.0 if m == j else 0.0) - n[m] * n[j] - along * dn[m, j] - n[m] * qdn
                    value += M[i, m] * de
                block[i, j] = value
        if not _scatter(sample_nodes[s], sample_weights[s], block, node_ptr, node_adj, upper, data):
            return False
    return True


@kernel
def energies(points, area, origin, axis, radius, stiffness, ramp):
    """Stored energy of all samples."""
    n = np.empty(3)
    total = 0.0
    for s in range(points.shape[0]):
        total += area[s] * penalty(radial(points[s], origin, axis, n) - radius, stiffness, ramp)[0]
    return total


@kernel
def potential(points, touching, origin, axis, force, friction, stick, anchors):
    """Friction potential with the given normal forces (lagged)."""
    n, q = np.empty(3), np.empty(3)
    total = 0.0
    for k in range(touching.size):
        s = touching[k]
        if force[s] == 0.0:
            continue
        radial(points[s], origin, axis, n)
        for i in range(3):
            q[i] = points[s, i] - anchors[s, i]
        size = np.sqrt(max(dot(q, q) - dot(n, q) ** 2, 0.0))
        total += friction[s] * force[s] * stick * mobilisation_energy(size / stick)
    return total


@kernel(error_model="numpy")
def drag_anchors(points, origin, axis, radius, force, slip, stick, anchors):
    """Commit: anchors of free samples to the closest point, sliding ones follow at the stick distance."""
    n, na, foot = np.empty(3), np.empty(3), np.empty(3)
    for s in range(points.shape[0]):
        rho = radial(points[s], origin, axis, n)
        for i in range(3):
            foot[i] = points[s, i] + (radius - rho) * n[i]
        if force[s] == 0.0:
            anchors[s] = foot
        elif slip[s] > stick:
            for i in range(3):
                anchors[s, i] = foot[i] + stick / slip[s] * (anchors[s, i] - foot[i])
            rho = radial(anchors[s], origin, axis, na)
            for i in range(3):
                anchors[s, i] += (radius - rho) * na[i]
