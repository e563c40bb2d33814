"""Compiled loops of Coulomb friction between strands, and of strands with a cylinder.

A pair remembers one material point of each strand that lay where they touch when the last step was accepted,
and the elastic slip of then. With z their difference now (slave minus master), T = I - n n^T and (g1, g2) the basis of
the contact plane along the slave's tangent and across it,

    e = T z + e1 g1 + e2 g2          trial slip
    traction = k e                   while k |e| <= mu N
             = mu N e/|e|            beyond: the pair slides

and the force acts on those two material points, rolling and twisting included. On an accepted step the slip is cut to
mu N/k where the pair slides and both points are taken anew at the present contact, so that the contact may move on
along the strands and roll without end, while slip that is not cut stays.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact import material_points as material
from knotfem.contact.curve import hinge_share
from knotfem.contact.curve_contact_kernels import normal_rate, pair_geometry
from knotfem.contact.penalty import penalty
from knotfem.contact.tube import axial_basis
from knotfem.geometry.rotation import cross, dot
from knotfem.sparse.rod_pattern import add_blocks


@kernel
def contact_basis(x, base, weights, n, along, g):
    """Basis g (2, 3) of the contact plane and the slave's derivative `along` (3); returns its length in the plane."""
    for i in range(3):
        along[i] = weights[1, 0] * x[base, i] + weights[1, 1] * x[base + 1, i] + weights[1, 2] * x[base + 2, i]
    part = dot(n, along)
    for i in range(3):
        g[0, i] = along[i] - part * n[i]
    size = np.sqrt(dot(g[0], g[0]))
    for i in range(3):
        g[0, i] /= size
    cross(n, g[0], g[1])
    return size


@kernel(inline="always")
def trial_slip(n, z, g, stored, e):
    """Trial slip e (3); returns its size."""
    along = dot(n, z)
    for i in range(3):
        e[i] = z[i] - along * n[i] + stored[0] * g[0, i] + stored[1] * g[1, i]
    return np.sqrt(dot(e, e))


@kernel(inline="always")
def slip_rate(n, z, along, g, size, stored, dz, dn, dalong, de, work):
    """Derivative of the trial slip along (dz, dn, dalong) into de; work is scratch (3, 3)."""
    nz, na = dot(n, z), dot(n, along)
    turn = dot(n, dz) + dot(dn, z)
    lean = dot(n, dalong) + dot(dn, along)
    for i in range(3):
        work[0, i] = dalong[i] - dn[i] * na - n[i] * lean
    stretch = dot(g[0], work[0])
    for i in range(3):
        work[0, i] = (work[0, i] - stretch * g[0, i]) / size
    cross(dn, g[0], work[1])
    cross(n, work[0], work[2])
    for i in range(3):
        de[i] = dz[i] - dn[i] * nz - n[i] * turn
        de[i] += stored[0] * work[0, i] + stored[1] * (work[1, i] + work[2, i])


@kernel(inline="always")
def traction_of(e, size, k, limit, out):
    """Traction into out; returns whether the pair slides."""
    scale = k
    slides = k * size > limit
    if slides:
        scale = limit / size
    for i in range(3):
        out[i] = scale * e[i]
    return slides


@kernel(inline="always")
def traction_rate(e, size, k, limit, slides, de, dlimit, out):
    """Derivative of the traction into out."""
    if not slides:
        for i in range(3):
            out[i] = k * de[i]
        return
    along = dot(e, de) / (size * size)
    for i in range(3):
        out[i] = limit / size * (de[i] - along * e[i]) + dlimit * e[i] / size


@kernel
def assemble(
    x, frames, first, sample_base, sample_weights, sample_share, length, points, pairs, u, gap, share, stiffness, ramp,
    spring, friction, own, anchor_u, anchor, stored, residual, tangent, node_ptr, node_adj, data, slip, traction,
):  # fmt: skip
    """Residual and tangent of the friction of all pairs.

    `frames` is `Frames.material_arrays`. Of each pair: `friction` mu, `own` (3) and `anchor` (3) the angle, radial and
    axial coordinates of the slave's and the master's material point, the latter at `anchor_u`, `stored` (2) the
    elastic slip in the basis of the contact plane [mm]; `slip` and `traction` (3) are filled with the size of the
    trial slip [mm] and the force on the master [N]. `spring` is the tangential stiffness [N/mm^2].

    Returns:
        False where a block lies outside the pattern.
    """
    per_radius = frames[3]
    w, C, q, n = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    nodes, B, Bd, dn3 = np.empty(6, np.int64), np.empty(6), np.empty(6), np.empty((3, 3))
    V, L = material.workspace()
    VA, LA = material.workspace()
    P, A, z, along, g, e = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3)
    GP, GA, HP, HA = np.empty((3, 12)), np.empty((3, 12)), np.empty((12, 12)), np.empty((12, 12))
    wa, T, work, scratch = np.empty((3, 3)), np.empty(3), np.empty((3, 3)), np.empty((16, 3))
    dz, dn, dalong, de, dT = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    rows, columns, block = np.empty(6, np.int64), np.empty(9, np.int64), np.empty((24, 36))
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        slip[k] = 0.0
        for i in range(3):
            traction[k, i] = 0.0
        _, pressure, slope = penalty(gap[k], stiffness, ramp)
        weight = length[s] * share[k]
        if weight * pressure == 0.0 or friction[k] == 0.0:
            continue
        count = first[rod + 1] - first[rod]
        size, h, _ = pair_geometry(
            x, first[rod], count, points[s], u[k], sample_base[s], sample_weights[s], w, C, q, n, nodes, B, Bd
        )
        base = sample_base[s]
        material.material_frame(x, base, sample_share[s], frames, own[k, 0], V, L)
        material.material_point(x, base, sample_weights[s, 0], own[k, 1], own[k, 2], V, P)
        local = axial_basis(anchor_u[k], count, wa)
        lies = hinge_share(anchor_u[k], local)
        ahead = first[rod] + local
        material.material_frame(x, ahead, lies, frames, anchor[k, 0], VA, LA)
        material.material_point(x, ahead, wa[0], anchor[k, 1], anchor[k, 2], VA, A)
        for i in range(3):
            z[i] = P[i] - A[i]
        width = contact_basis(x, base, sample_weights[s], n, along, g)
        slip[k] = trial_slip(n, z, g, stored[k], e)
        limit = friction[k] * weight * pressure
        slides = traction_of(e, slip[k], spring * weight, limit, T)
        material.material_gradient(
            base, sample_share[s], sample_weights[s, 0], per_radius, own[k, 1], own[k, 2], V, L, GP
        )
        material.material_gradient(ahead, lies, wa[0], per_radius, anchor[k, 1], anchor[k, 2], VA, LA, GA)
        for i in range(3):
            traction[k, i] = T[i]
            rows[i] = columns[i] = base + i
            columns[3 + i] = nodes[3 + i]
            rows[3 + i] = columns[6 + i] = ahead + i
        for c in range(12):
            residual[rows[c // 4], c % 4] += GP[0, c] * T[0] + GP[1, c] * T[1] + GP[2, c] * T[2]
            residual[rows[3 + c // 4], c % 4] -= GA[0, c] * T[0] + GA[1, c] * T[1] + GA[2, c] * T[2]
        if not tangent:
            continue
        material.material_curvature(base, sample_share[s], frames, own[k, 1], own[k, 2], V, L, T, HP, scratch)
        material.material_curvature(ahead, lies, frames, anchor[k, 1], anchor[k, 2], VA, LA, T, HA, scratch)
        for c in range(36):
            node, part = c // 4, c % 4
            dgap = 0.0
            for i in range(3):
                dz[i] = dn[i] = dalong[i] = 0.0
            if node < 3:
                for i in range(3):
                    dz[i] = GP[i, c]
            elif node >= 6:
                for i in range(3):
                    dz[i] = -GA[i, c - 24]
            if node < 6 and part < 3:
                normal_rate(B[node], Bd[node], n, size, C[1], h, dn3)
                dgap = B[node] * n[part]
                for i in range(3):
                    dn[i] = dn3[i, part]
                if node < 3:
                    dalong[part] = sample_weights[s, 1, node]
            slip_rate(n, z, along, g, width, stored[k], dz, dn, dalong, de, work)
            traction_rate(e, slip[k], spring * weight, limit, slides, de, -friction[k] * weight * slope * dgap, dT)
            for a in range(12):
                block[a, c] = GP[0, a] * dT[0] + GP[1, a] * dT[1] + GP[2, a] * dT[2]
                block[12 + a, c] = -(GA[0, a] * dT[0] + GA[1, a] * dT[1] + GA[2, a] * dT[2])
        for a in range(12):
            for c in range(12):
                block[a, c] += HP[a, c]
                block[12 + a, 24 + c] -= HA[a, c]
        if not add_blocks(rows, columns, block, node_ptr, node_adj, data):
            return False
    return True


@kernel
def slip_scratch():
    """Room for `pair_slip`: w, C, q, n, nodes, B, B', z, the slave's derivative, g, the slip e, two points."""
    return (
        np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(6, np.int64), np.empty(6), np.empty(6),
        np.empty(3), np.empty(3), np.empty((2, 3)), np.empty(3), np.empty(3), np.empty(3),
    )  # fmt: skip


@kernel
def pair_slip(x, frames, first, count, base, weights, share, point, u, own, anchor_u, anchor, stored, V, L, room):
    """Trial slip of one pair, its master a rod of `count` nodes from `first` on; fills g and e of `room`."""
    w, C, q, n, nodes, B, Bd, z, along, g, e, P, A = room
    pair_geometry(x, first, count, point, u, base, weights, w, C, q, n, nodes, B, Bd)
    material.material_frame(x, base, share, frames, own[0], V, L)
    material.material_point(x, base, weights[0], own[1], own[2], V, P)
    local = axial_basis(anchor_u, count, w)
    material.material_frame(x, first + local, hinge_share(anchor_u, local), frames, anchor[0], V, L)
    material.material_point(x, first + local, w[0], anchor[1], anchor[2], V, A)
    for i in range(3):
        z[i] = P[i] - A[i]
    contact_basis(x, base, weights, n, along, g)
    return trial_slip(n, z, g, stored, e)


@kernel
def potential(
    x, frames, first, sample_base, sample_weights, sample_share, length, points, pairs, u, share, spring, friction,
    force, own, anchor_u, anchor, stored,
):  # fmt: skip
    """Friction potential with the given normal forces (lagged), for the line search."""
    V, L = material.workspace()
    room = slip_scratch()
    total = 0.0
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        limit = friction[k] * force[k]
        if limit == 0.0:
            continue
        size = pair_slip(
            x, frames, first[rod], first[rod + 1] - first[rod], sample_base[s], sample_weights[s], sample_share[s],
            points[s], u[k], own[k], anchor_u[k], anchor[k], stored[k], V, L, room,
        )  # fmt: skip
        total += slip_potential(size, spring * length[s] * share[k], limit)
    return total


@kernel(inline="always")
def slip_potential(size, k, limit):
    """Integral of the traction over the slip."""
    if k * size <= limit:
        return 0.5 * k * size * size
    return limit * size - 0.5 * limit * limit / k


@kernel(inline="always")
def sliding_work(stiffness, before, after, trial):
    """Work of sliding when the slip is cut from `trial` to `after`, having been `before` a step ago; never negative.

    The spring works against the motion with a traction that goes linearly from one end of the step to the other; what
    it does not store is lost. That covers a spring that gives way because the normal force has fallen.
    """
    return 0.5 * stiffness * (before + after) * (trial - after)


@kernel
def anchor_pairs(
    x, frames, first, radius, sample_rod, sample_base, sample_weights, sample_share, points, pairs, u, chosen, own,
    anchor_u, anchor,
):  # fmt: skip
    """Take both material points of the chosen pairs anew, where the present contact divides the way between the axes.

    That way is divided as the radii are: two rods that roll on each other turn inversely as those.
    """
    w, C, q, n = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    nodes, B, Bd, d = np.empty(6, np.int64), np.empty(6), np.empty(6), np.empty(3)
    V, L = material.workspace()
    for k in range(pairs.shape[0]):
        if not chosen[k]:
            continue
        s, rod = pairs[k]
        _, _, base = pair_geometry(
            x, first[rod], first[rod + 1] - first[rod], points[s], u[k], sample_base[s], sample_weights[s], w, C, q, n,
            nodes, B, Bd,
        )  # fmt: skip
        part = radius[sample_rod[s]] / (radius[sample_rod[s]] + radius[rod])
        for i in range(3):
            d[i] = -part * q[i]
        own[k, 0] = material.material_angle(x, sample_base[s], sample_share[s], frames, d, V, L)
        own[k, 2] = dot(d, V[material.T])
        own[k, 1] = np.sqrt(max(dot(d, d) - own[k, 2] ** 2, 0.0))
        for i in range(3):
            d[i] = (1.0 - part) * q[i]
        anchor_u[k] = u[k]
        lies = hinge_share(u[k], base - first[rod])
        anchor[k, 0] = material.material_angle(x, base, lies, frames, d, V, L)
        anchor[k, 2] = dot(d, V[material.T])
        anchor[k, 1] = np.sqrt(max(dot(d, d) - anchor[k, 2] ** 2, 0.0))


@kernel
def commit(
    x, frames, first, sample_base, sample_weights, sample_share, length, points, pairs, u, share, spring, friction,
    force, own, anchor_u, anchor, stored,
):  # fmt: skip
    """Cut the slip of sliding pairs; returns what sliding has dissipated [N mm] and the elastic energy that stays.

    The work of sliding is traction times cut, never negative; a pair whose normal force has fallen gives up the elastic
    energy that it cannot hold any more.
    """
    V, L = material.workspace()
    room = slip_scratch()
    g, e = room[9], room[10]
    lost, kept = 0.0, 0.0
    for k in range(pairs.shape[0]):
        s, rod = pairs[k]
        stiffness = spring * length[s] * share[k]
        limit = friction[k] * force[k]
        before = np.sqrt(stored[k, 0] ** 2 + stored[k, 1] ** 2)
        if limit == 0.0:
            lost += sliding_work(stiffness, before, 0.0, before)
            stored[k, 0] = stored[k, 1] = 0.0
            continue
        size = pair_slip(
            x, frames, first[rod], first[rod + 1] - first[rod], sample_base[s], sample_weights[s], sample_share[s],
            points[s], u[k], own[k], anchor_u[k], anchor[k], stored[k], V, L, room,
        )  # fmt: skip
        scale = 1.0
        if stiffness * size > limit:
            scale = limit / (stiffness * size)
            lost += sliding_work(stiffness, before, scale * size, size)
        stored[k, 0], stored[k, 1] = scale * dot(e, g[0]), scale * dot(e, g[1])
        kept += 0.5 * stiffness * (scale * size) ** 2
    return lost, kept
