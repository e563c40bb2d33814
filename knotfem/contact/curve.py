"""Smooth centrelines of discrete rods: the uniform quadratic B-spline whose control points are the nodes.

It fits a discrete elastic rod: in the middle of each edge it passes through the edge and along it, between two middles
its tangent goes from one edge's direction to the next along the great circle, just as directors are carried over the
vertex. Gaps and directions are therefore smooth where a chain of capsules has a ripple. On an arc of curvature kappa it
runs a constant h^2 kappa/12 inside the arc of the same length: a small error of second order, without ripple.
The arclength coordinate u counts segments; beyond its ends the curve goes straight on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.basis import axial_basis
from knotfem.contact.pieces import middles
from knotfem.contact.samples import Samples, SampleView
from knotfem.geometry.rotation import dot
from knotfem.mesh.rod_layout import RodLayout


class CurveView(NamedTuple):
    """Centrelines of all rods.

    Attributes:
        first: first node of each rod and the number of all, shape [rods + 1].
        radius: of each rod [mm], shape [rods].
    """

    first: np.ndarray
    radius: np.ndarray


class CurveRoom(NamedTuple):
    """Work space for one point of a centreline.

    Attributes:
        w: weights of three nodes in the place and its first and second derivative by u, shape [3, 3].
        C: these three, shape [3, 3].
        q: a point minus the place, shape [3].
    """

    w: np.ndarray
    C: np.ndarray
    q: np.ndarray


@kernel
def curve_room() -> CurveRoom:
    """Work space for one point."""
    return CurveRoom(np.empty((3, 3)), np.empty((3, 3)), np.empty(3))


@kernel(inline="always")
def between_middles(u: float, first: int) -> float:
    """Where between the middles of its two edges a point lies, 0 to 1, for a stencil that begins at `first`."""
    return min(max(u - first - 0.5, 0.0), 1.0)


@kernel(inline="always")
def curve_point(x: np.ndarray, base: int, w: np.ndarray, C: np.ndarray) -> None:
    """Place, first and second derivative by u into C (3, 3), for weights w (3, 3) at nodes base to base + 2."""
    for d in range(3):
        for i in range(3):
            C[d, i] = w[d, 0] * x[base, i] + w[d, 1] * x[base + 1, i] + w[d, 2] * x[base + 2, i]


@kernel(inline="always")
def _point_seen(x: np.ndarray, first_node: int, count: int, p: np.ndarray, u: float, room: CurveRoom) -> int:
    """The point at u with its derivatives and q = p - C into `room`; returns the first node of its stencil."""
    base = first_node + axial_basis(u, count, room.w)
    curve_point(x, base, room.w, room.C)
    for i in range(3):
        room.q[i] = p[i] - room.C[0, i]
    return base


@kernel
def project(
    x: np.ndarray, curves: CurveView, rod: int, p: np.ndarray, u: float, room: CurveRoom
) -> tuple[float, int, bool]:
    """Closest point of a rod's centreline to p by Newton from u; on return `room` belongs to it.

    Returns:
        u, first node of the stencil, and whether a minimum was found on the rod or at most one segment beyond its ends.
    """
    C, q = room.C, room.q
    first_node: int = curves.first[rod]
    count: int = curves.first[rod + 1] - first_node
    last = count - 1.0
    for attempt in range(40):
        base = _point_seen(x, first_node, count, p, u, room)
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
    base = _point_seen(x, first_node, count, p, u, room)
    return u, base, abs(dot(q, C[1])) < 1e-9 * dot(C[1], C[1])


def make_samples(layout: RodLayout, spacing: float) -> Samples:
    """Samples no further apart than `spacing` [mm], in the middles of equal pieces of each segment."""
    rods, us, lengths, starts = [], [], [], [0]
    for rod in range(layout.rods):
        slices = layout.slices(rod)
        u, length = middles(slices, spacing)
        us.append(u)
        rods.append(np.full(u.size, rod))
        lengths.append(length)
        starts.extend(starts[-1] + np.searchsorted(u, np.arange(slices.count + 1) + 0.5, side="left"))
    rod, u = np.concatenate(rods).astype(np.int64), np.concatenate(us)
    nodes, weights, between = np.empty((u.size, 3), dtype=np.int64), np.empty((u.size, 3, 3)), np.empty(u.size)
    for s in range(u.size):
        local = axial_basis(u[s], int(layout.first[rod[s] + 1] - layout.first[rod[s]]), weights[s])
        nodes[s] = layout.first[rod[s]] + local + np.arange(3)
        between[s] = between_middles(u[s], local)
    radius = np.asarray(layout.radius, dtype=float)[rod]
    place, rates = weights[:, 0].copy(), weights[:, 1].copy()
    view = SampleView(rod, u[:, None].copy(), nodes, place, rates, between, np.concatenate(lengths), radius)
    return Samples(view, np.array(starts, dtype=np.int64))
