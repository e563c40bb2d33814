"""Compiled loops of strands and a rigid cylinder: the other body has no unknowns, all else is as between strands.

A sample p at the distance rho from the axis has the gap rho - R - r, grad = n (radial) and
dn = (I - n n^T - a a^T) dp/rho.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.curve_friction_kernels import (
    contact_basis,
    sliding_work,
    slip_potential,
    slip_rate,
    traction_of,
    traction_rate,
    trial_slip,
)
from knotfem.contact.penalty import penalty
from knotfem.contact.tube_cylinder_kernels import radial
from knotfem.geometry.rotation import dot
from knotfem.sparse.rod_pattern import add_blocks


@kernel
def gaps(points, sample_radius, origin, axis, radius, gap):
    """Gap of every sample."""
    n = np.empty(3)
    for s in range(points.shape[0]):
        gap[s] = radial(points[s], origin, axis, n) - radius - sample_radius[s]


@kernel
def assemble(
    sample_base, sample_weights, length, points, origin, axis, gap, stiffness, ramp, residual,
    tangent, node_ptr, node_adj, data, force,
):  # fmt: skip
    """Normal contact; `force` (samples) is filled. False outside the pattern."""
    n, nodes, block = np.empty(3), np.empty(3, np.int64), np.zeros((12, 12))
    for s in range(gap.size):
        _, pressure, slope = penalty(gap[s], stiffness, ramp)
        force[s] = length[s] * pressure
        if pressure == 0.0:
            continue
        rho = radial(points[s], origin, axis, n)
        for a in range(3):
            nodes[a] = sample_base[s] + a
            for i in range(3):
                residual[nodes[a], i] -= force[s] * sample_weights[s, 0, a] * n[i]
        if not tangent:
            continue
        for i in range(3):
            for j in range(3):
                turn = ((1.0 if i == j else 0.0) - n[i] * n[j] - axis[i] * axis[j]) / rho
                value = length[s] * slope * n[i] * n[j] - force[s] * turn
                for a in range(3):
                    for c in range(3):
                        block[4 * a + i, 4 * c + j] = value * sample_weights[s, 0, a] * sample_weights[s, 0, c]
        if not add_blocks(nodes, nodes, block, node_ptr, node_adj, data):
            return False
    return True


@kernel
def energy(length, gap, stiffness, ramp):
    """Stored energy of all samples."""
    total = 0.0
    for s in range(gap.size):
        total += length[s] * penalty(gap[s], stiffness, ramp)[0]
    return total


@kernel
def assemble_friction(
    x, frames, sample_base, sample_weights, sample_share, length, points, origin, axis, gap, stiffness, ramp, spring,
    friction, own, anchor, stored, residual, tangent, node_ptr, node_adj, data, slip, traction,
):  # fmt: skip
    """Friction from the points `anchor` (samples, 3) of the cylinder; see `curve_friction_kernels.assemble`."""
    per_radius = frames[3]
    n, z, along, g, e = np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3)
    V, L = material.workspace()
    P, T, work, scratch = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((16, 3))
    G, H, nodes = np.empty((3, 12)), np.empty((12, 12)), np.empty(3, np.int64)
    dz, dn, dalong, de, dT = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    block = np.empty((12, 12))
    for s in range(gap.size):
        slip[s] = 0.0
        for i in range(3):
            traction[s, i] = 0.0
        _, pressure, slope = penalty(gap[s], stiffness, ramp)
        if pressure == 0.0 or friction[s] == 0.0:
            continue
        rho = radial(points[s], origin, axis, n)
        base = sample_base[s]
        material.material_frame(x, base, sample_share[s], frames, own[s, 0], V, L)
        material.material_point(x, base, sample_weights[s, 0], own[s, 1], own[s, 2], V, P)
        for i in range(3):
            z[i] = P[i] - anchor[s, i]
            nodes[i] = base + i
        width = contact_basis(x, base, sample_weights[s], n, along, g)
        slip[s] = trial_slip(n, z, g, stored[s], e)
        limit = friction[s] * length[s] * pressure
        slides = traction_of(e, slip[s], spring * length[s], limit, T)
        material.material_gradient(
            base, sample_share[s], sample_weights[s, 0], per_radius, own[s, 1], own[s, 2], V, L, G
        )
        for i in range(3):
            traction[s, i] = T[i]
        for c in range(12):
            residual[nodes[c // 4], c % 4] += G[0, c] * T[0] + G[1, c] * T[1] + G[2, c] * T[2]
        if not tangent:
            continue
        material.material_curvature(base, sample_share[s], frames, own[s, 1], own[s, 2], V, L, T, H, scratch)
        for c in range(12):
            node, part = c // 4, c % 4
            dgap = 0.0
            for i in range(3):
                dz[i] = G[i, c]
                dn[i] = dalong[i] = 0.0
            if part < 3:
                weight = sample_weights[s, 0, node]
                dgap = weight * n[part]
                for i in range(3):
                    dn[i] = weight * ((1.0 if i == part else 0.0) - n[i] * n[part] - axis[i] * axis[part]) / rho
                dalong[part] = sample_weights[s, 1, node]
            slip_rate(n, z, along, g, width, stored[s], dz, dn, dalong, de, work)
            dlimit = -friction[s] * length[s] * slope * dgap
            traction_rate(e, slip[s], spring * length[s], limit, slides, de, dlimit, dT)
            for a in range(12):
                block[a, c] = H[a, c] + G[0, a] * dT[0] + G[1, a] * dT[1] + G[2, a] * dT[2]
        if not add_blocks(nodes, nodes, block, node_ptr, node_adj, data):
            return False
    return True


@kernel
def slip_of(x, frames, base, weights, share, point, origin, axis, own, anchor, stored, n, g, e, V, L, z, along):
    """Trial slip of a sample into e; fills n and g."""
    radial(point, origin, axis, n)
    material.material_frame(x, base, share, frames, own[0], V, L)
    material.material_point(x, base, weights[0], own[1], own[2], V, z)
    for i in range(3):
        z[i] -= anchor[i]
    contact_basis(x, base, weights, n, along, g)
    return trial_slip(n, z, g, stored, e)


@kernel
def potential(
    x, frames, sample_base, sample_weights, sample_share, length, points, origin, axis, spring, friction, force, own,
    anchor, stored,
):  # fmt: skip
    """Friction potential with the given normal forces (lagged), for the line search."""
    n, z, along, g, e = np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3)
    V, L = material.workspace()
    total = 0.0
    for s in range(length.size):
        limit = friction[s] * force[s]
        if limit > 0.0:
            size = slip_of(
                x, frames, sample_base[s], sample_weights[s], sample_share[s], points[s], origin, axis, own[s],
                anchor[s], stored[s], n, g, e, V, L, z, along,
            )  # fmt: skip
            total += slip_potential(size, spring * length[s], limit)
    return total


@kernel
def anchor_samples(
    x, frames, sample_base, sample_weights, sample_share, points, origin, axis, radius, gap, reach, own, anchor
):
    """Take both material points of near samples anew, where they meet on the cylinder."""
    n, d = np.empty(3), np.empty(3)
    V, L = material.workspace()
    for s in range(gap.size):
        if gap[s] > reach:
            continue
        rho = radial(points[s], origin, axis, n)
        for i in range(3):
            d[i] = (radius - rho) * n[i]
            anchor[s, i] = points[s, i] + d[i]
        own[s, 0] = material.material_angle(x, sample_base[s], sample_share[s], frames, d, V, L)
        own[s, 2] = dot(d, V[material.T])
        own[s, 1] = np.sqrt(max(dot(d, d) - own[s, 2] ** 2, 0.0))


@kernel
def commit(
    x, frames, sample_base, sample_weights, sample_share, length, points, origin, axis, spring, friction, force, own,
    anchor, stored,
):  # fmt: skip
    """Cut the slip of sliding samples; see `knotfem.contact.curve_friction_kernels.commit`."""
    n, z, along, g, e = np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3)
    V, L = material.workspace()
    lost, kept = 0.0, 0.0
    for s in range(length.size):
        limit = friction[s] * force[s]
        stiffness = spring * length[s]
        before = np.sqrt(stored[s, 0] ** 2 + stored[s, 1] ** 2)
        if limit == 0.0:
            lost += sliding_work(stiffness, before, 0.0, before)
            stored[s, 0] = stored[s, 1] = 0.0
            continue
        size = slip_of(
            x, frames, sample_base[s], sample_weights[s], sample_share[s], points[s], origin, axis, own[s], anchor[s],
            stored[s], n, g, e, V, L, z, along,
        )  # fmt: skip
        scale = 1.0
        if stiffness * size > limit:
            scale = limit / (stiffness * size)
            lost += sliding_work(stiffness, before, scale * size, size)
        stored[s, 0], stored[s, 1] = scale * dot(e, g[0]), scale * dot(e, g[1])
        kept += 0.5 * stiffness * (scale * size) ** 2
    return lost, kept
