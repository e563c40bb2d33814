"""The smooth centreline: the uniform quadratic B-spline whose control points are the nodes.

It fits a discrete elastic rod: in the middle of each edge it passes through the edge and along it, between two middles
its tangent goes from one edge's direction to the next along the great circle, just as directors are carried over the
hinge. Gaps and directions are therefore smooth where a chain of capsules has a ripple. On an arc of curvature kappa it
runs a constant h^2 kappa/12 inside the arc of the same length: a small error of second order, without ripple.
The arclength coordinate u counts segments; beyond its ends the curve goes straight on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.tube import axial_basis
from knotfem.geometry.rotation import dot
from knotfem.mesh.rod_layout import RodLayout


@kernel(inline="always")
def hinge_share(u, first):
    """Where between the middles of its two edges a point lies, 0 to 1, for a stencil that begins at `first`."""
    return min(max(u - first - 0.5, 0.0), 1.0)


@kernel(inline="always")
def curve_point(x, base, w, C):
    """Place, first and second derivative by u into C (3, 3), for weights w (3, 3) at nodes base, base + 1, base + 2."""
    for d in range(3):
        for i in range(3):
            C[d, i] = w[d, 0] * x[base, i] + w[d, 1] * x[base + 1, i] + w[d, 2] * x[base + 2, i]


@kernel
def project(x, first_node, count, p, u, w, C, q):
    """Closest point of a rod's curve to p by Newton from u; on return w, C and q = p - curve belong to it.

    The rod has `count` nodes from `first_node` on; w and C are (3, 3), q is (3).

    Returns:
        u, first node of the stencil, and whether a minimum was found on the rod or at most one segment beyond its ends.
    """
    last = count - 1.0
    for attempt in range(40):
        base = first_node + axial_basis(u, count, w)
        curve_point(x, base, w, C)
        for i in range(3):
            q[i] = p[i] - C[0, i]
        slope, metric = dot(q, C[1]), dot(C[1], C[1])
        stiffness = metric - dot(q, C[2])
        if stiffness < 0.05 * metric:
            stiffness = metric
        step = slope / stiffness
        if not abs(step) < 1e3:
            return u, base, False
        if abs(step) < 1e-13:
            return u, base, metric > dot(q, C[2])
        limit = 0.7 if attempt < 12 else 0.1
        u += min(max(step, -limit), limit)
        if u < -1.0 or u > last + 1.0:
            return u, base, False
    base = first_node + axial_basis(u, count, w)
    curve_point(x, base, w, C)
    for i in range(3):
        q[i] = p[i] - C[0, i]
    return u, base, abs(dot(q, C[1])) < 1e-9 * dot(C[1], C[1])


@dataclass(frozen=True, eq=False)
class Samples:
    """Fixed material points of the centrelines at which contact is looked for.

    Attributes:
        rod: shape [samples].
        u: coordinate along the rod in segments, shape [samples].
        base: first of the three nodes of each, shape [samples].
        weights: of place, first and second derivative, shape [samples, 3, 3].
        share: between the middles of the two edges, 0 to 1, shape [samples].
        length: that each stands for [mm], shape [samples].
        start: first sample of each rod and the number of all, shape [rods + 1].
    """

    rod: np.ndarray
    u: np.ndarray
    base: np.ndarray
    weights: np.ndarray
    share: np.ndarray
    length: np.ndarray
    start: np.ndarray


@kernel
def sample_points(x, base, weights, out):
    """Places of samples into out, shape [samples, 3]."""
    for s in range(base.size):
        for i in range(3):
            out[s, i] = 0.0
            for a in range(3):
                out[s, i] += weights[s, 0, a] * x[base[s] + a, i]


def make_samples(layout: RodLayout, spacing: float) -> Samples:
    """Samples no further apart than `spacing` [mm], in the middles of equal pieces of each segment."""
    rods, us, lengths = [], [], []
    for rod in range(layout.rods):
        h, nodes = float(layout.spacing[rod]), int(layout.first[rod + 1] - layout.first[rod])
        pieces = max(1, int(np.ceil(h / spacing - 1e-9)))
        us.append((np.arange((nodes - 1) * pieces) + 0.5) / pieces)
        rods.append(np.full(us[-1].size, rod))
        lengths.append(np.full(us[-1].size, h / pieces))
    rod, u = np.concatenate(rods), np.concatenate(us)
    base, weights, share = np.empty(u.size, dtype=np.int64), np.empty((u.size, 3, 3)), np.empty(u.size)
    for s in range(u.size):
        nodes = int(layout.first[rod[s] + 1] - layout.first[rod[s]])
        local = axial_basis(u[s], nodes, weights[s])
        base[s], share[s] = layout.first[rod[s]] + local, hinge_share(u[s], local)
    start = np.concatenate([[0], np.cumsum([part.size for part in us])]).astype(np.int64)
    return Samples(rod.astype(np.int64), u, base, weights, share, np.concatenate(lengths), start)
