"""Smooth surfaces of rods: bi-quadratic B-spline tubes over the boundary nodes.

Along a rod the spline is uniform with straight ghost points beyond its ends, around it periodic. Parameters: u counts
slices, 0 to n; v counts boundary nodes, 0 to k. Over a regular polygon of unit circumradius the tube's radius is
3/4 + 1/4 cos(2 pi/k) at the nodes and cos(pi/k) between, equal to 0.02 % for k = 16. To give the shrinkage back, the
control points stand on the line from the axis node through the boundary node, further out by a constant factor: the
surface stays linear in the positions, and it is the physical one, so that friction acts on its true lever arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.compiled import kernel


@dataclass(frozen=True, eq=False)
class Tubes:
    """Surfaces of all rods, flattened for compiled loops.

    Attributes:
        ring: boundary nodes, section after section, rod after rod.
        ring_start: where each rod begins in `ring`, shape [rods].
        around: boundary nodes a section, shape [rods].
        axis: axis nodes, rod after rod.
        axis_start: where each rod begins in `axis`, shape [rods].
        sections: sections of each rod (slices + 1), shape [rods].
        spacing: slice length [mm], shape [rods].
        radius: [mm], shape [rods].
        swell: distance of control points over that of boundary nodes from the axis, shape [rods].
    """

    ring: np.ndarray
    ring_start: np.ndarray
    around: np.ndarray
    axis: np.ndarray
    axis_start: np.ndarray
    sections: np.ndarray
    spacing: np.ndarray
    radius: np.ndarray
    swell: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """Arguments of the compiled loops, in their order."""
        return self.ring, self.ring_start, self.around, self.sections, self.axis, self.axis_start, self.swell


def spline_radius(around: int) -> float:
    """Mean radius of the periodic quadratic B-spline over a regular polygon of unit circumradius."""
    return 0.5 * (0.75 + 0.25 * np.cos(2 * np.pi / around) + np.cos(np.pi / around))


def make_tubes(
    rings: list[np.ndarray], axes: list[np.ndarray], spacing: list[float], radius: list[float], node_radius: list[float]
) -> Tubes:
    """Tubes over the boundary nodes of rods.

    Args:
        rings: boundary nodes of each rod, shape [sections, around].
        axes: axis nodes of each rod, shape [sections].
        spacing: slice length of each rod [mm].
        radius: physical radius [mm].
        node_radius: distance of the boundary nodes from the axis [mm].
    """
    around = np.array([ring.shape[1] for ring in rings])
    sections = np.array([ring.shape[0] for ring in rings])
    starts = np.concatenate([[0], np.cumsum(around * sections)[:-1]])
    swell = [r / (n * spline_radius(k)) for r, n, k in zip(radius, node_radius, around, strict=True)]
    return Tubes(
        np.concatenate([ring.ravel() for ring in rings]).astype(np.int64),
        starts.astype(np.int64),
        around.astype(np.int64),
        np.concatenate(axes).astype(np.int64),
        np.concatenate([[0], np.cumsum(sections)[:-1]]).astype(np.int64),
        sections.astype(np.int64),
        np.array(spacing, dtype=float),
        np.array(radius, dtype=float),
        np.array(swell, dtype=float),
    )


@kernel(inline="always")
def axial_basis(u, sections, w):
    """Quadratic basis, first and second derivatives along the rod into w (3, 3); returns the first node."""
    i = int(np.floor(u + 0.5))
    i = min(max(i, 0), sections - 1)
    t = u - i
    w[0, 0], w[0, 1], w[0, 2] = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    w[1, 0], w[1, 1], w[1, 2] = t - 0.5, -2.0 * t, t + 0.5
    w[2, 0], w[2, 1], w[2, 2] = 1.0, -2.0, 1.0
    if i == 0:
        for d in range(3):
            ghost, at, after = w[d, 0], w[d, 1], w[d, 2]
            w[d, 0], w[d, 1], w[d, 2] = at + 2.0 * ghost, after - ghost, 0.0
        return 0
    if i == sections - 1:
        for d in range(3):
            before, at, ghost = w[d, 0], w[d, 1], w[d, 2]
            w[d, 0], w[d, 1], w[d, 2] = 0.0, before - ghost, at + 2.0 * ghost
        return sections - 3
    return i - 1


@kernel(inline="always")
def ring_basis(v, around, w):
    """Quadratic basis, first and second derivatives around the rod into w (3, 3); returns the middle node."""
    j = int(np.floor(v + 0.5))
    t = v - j
    w[0, 0], w[0, 1], w[0, 2] = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    w[1, 0], w[1, 1], w[1, 2] = t - 0.5, -2.0 * t, t + 0.5
    w[2, 0], w[2, 1], w[2, 2] = 1.0, -2.0, 1.0
    return j % around


@kernel
def stencil(tubes, rod, u, v, nodes, W):
    """Nodes (12) of the patch at (u, v) of a rod and their weights W (6, 12) in S, S_u, S_v, S_uu, S_uv, S_vv.

    In each of three sections three boundary nodes and the axis node.
    """
    ring, ring_start, around, sections, axis, axis_start, swell = tubes
    wu = np.empty((3, 3))
    wv = np.empty((3, 3))
    k = around[rod]
    c = swell[rod]
    first = axial_basis(u, sections[rod], wu)
    middle = ring_basis(v, k, wv)
    for a in range(3):
        row = ring_start[rod] + (first + a) * k
        for b in range(4):
            p = 4 * a + b
            if b < 3:
                nodes[p] = ring[row + (middle + b - 1 + k) % k]
                W[0, p] = c * wu[0, a] * wv[0, b]
                W[1, p] = c * wu[1, a] * wv[0, b]
                W[2, p] = c * wu[0, a] * wv[1, b]
                W[3, p] = c * wu[2, a] * wv[0, b]
                W[4, p] = c * wu[1, a] * wv[1, b]
                W[5, p] = c * wu[0, a] * wv[2, b]
            else:
                nodes[p] = axis[axis_start[rod] + first + a]
                W[0, p] = (1.0 - c) * wu[0, a]
                W[1, p] = (1.0 - c) * wu[1, a]
                W[2, p] = 0.0
                W[3, p] = (1.0 - c) * wu[2, a]
                W[4, p] = 0.0
                W[5, p] = 0.0


@kernel(inline="always")
def surface_point(x, nodes, W, S):
    """S, S_u, S_v, S_uu, S_uv, S_vv into S (6, 3)."""
    for d in range(6):
        for i in range(3):
            S[d, i] = 0.0
    for p in range(nodes.size):
        n = nodes[p]
        for d in range(6):
            for i in range(3):
                S[d, i] += W[d, p] * x[n, i]


@kernel(inline="always")
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(error_model="numpy")
def project(x, tubes, rod, p, u, v, W, nodes, S, q):
    """Closest point of a tube to p by Newton from (u, v); on return stencil, S and q = p - S belong to it.

    Returns:
        u, v, and whether it converged inside the rod or at most one slice beyond its ends; where the surface folds so
        that Newton's method goes round and round, shorter steps are taken.
    """
    last = tubes[3][rod] - 1.0
    largest = np.inf
    for attempt in range(30):
        stencil(tubes, rod, u, v, nodes, W)
        surface_point(x, nodes, W, S)
        for i in range(3):
            q[i] = p[i] - S[0, i]
        g1, g2 = dot(q, S[1]), dot(q, S[2])
        a11, a12, a22 = dot(S[1], S[1]), dot(S[1], S[2]), dot(S[2], S[2])
        h11, h12, h22 = a11 - dot(q, S[3]), a12 - dot(q, S[4]), a22 - dot(q, S[5])
        det = h11 * h22 - h12 * h12
        if h11 <= 0.0 or det <= 1e-3 * a11 * a22:
            h11, h12, h22 = a11, a12, a22
            det = h11 * h22 - h12 * h12
        du, dv = (h22 * g1 - h12 * g2) / det, (h11 * g2 - h12 * g1) / det
        if not (abs(du) < 1e3 and abs(dv) < 1e3):
            return u, v, False
        largest = max(abs(du), abs(dv))
        if largest < 1e-13:
            return u, v, True
        if largest < 1e-9:
            u, v = u + du, v + dv
            continue
        scale = min(1.0, (0.7 if attempt < 12 else 0.1) / largest)
        u, v = u + scale * du, v + scale * dv
        if u < -1.0 or u > last + 1.0:
            return min(max(u, -1.0), last + 1.0), v, False
    return u, v, largest < 1e-9


@dataclass(frozen=True, eq=False)
class Samples:
    """Fixed material points of the tubes at which contact is looked for.

    Attributes:
        rod: shape [samples].
        u: shape [samples].
        v: shape [samples].
        area: reference area each stands for [mm^2], shape [samples].
        nodes: stencil, shape [samples, 12].
        weights: shape [samples, 12].
        section_start: first sample nearest to each section, rods stacked, shape [all sections + 1].
    """

    rod: np.ndarray
    u: np.ndarray
    v: np.ndarray
    area: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    section_start: np.ndarray


@kernel
def _stencils(tubes, rod, u, v, nodes, weights):
    W = np.empty((6, 12))
    for s in range(rod.size):
        stencil(tubes, rod[s], u[s], v[s], nodes[s], W)
        weights[s] = W[0]


@kernel
def sample_points(x, nodes, weights, out):
    """Positions of samples into out, shape [samples, 3]."""
    for s in range(nodes.shape[0]):
        for i in range(3):
            value = 0.0
            for a in range(12):
                value += weights[s, a] * x[nodes[s, a], i]
            out[s, i] = value


def make_samples(tubes: Tubes, spacing: float) -> Samples:
    """Samples no further apart than `spacing` [mm] both ways, ends of the rods included."""
    rods, us, vs, areas, starts = [], [], [], [], [0]
    for rod in range(tubes.sections.size):
        k, sections, h, r = (int(tubes.around[rod]), int(tubes.sections[rod]), tubes.spacing[rod], tubes.radius[rod])
        along = max(1, int(np.ceil(h / spacing - 1e-9)))
        around = k * max(1, int(np.ceil(2 * np.pi * r / k / spacing - 1e-9)))
        u = np.arange((sections - 1) * along + 1) / along
        v = np.arange(around) * (k / around)
        area = np.full(u.size, h / along * 2 * np.pi * r / around)
        area[[0, -1]] *= 0.5
        us.append(np.repeat(u, around))
        vs.append(np.tile(v, u.size))
        areas.append(np.repeat(area, around))
        rods.append(np.full(u.size * around, rod))
        nearest = np.minimum(np.floor(u + 0.5).astype(int), sections - 1)
        starts.extend(starts[-1] + np.cumsum(np.bincount(nearest, minlength=sections)) * around)
    rod, u, v = np.concatenate(rods).astype(np.int64), np.concatenate(us), np.concatenate(vs)
    nodes = np.empty((u.size, 12), dtype=np.int64)
    weights = np.empty((u.size, 12))
    _stencils(tubes.arrays, rod, u, v, nodes, weights)
    return Samples(rod, u, v, np.concatenate(areas), nodes, weights, np.array(starts, dtype=np.int64))
