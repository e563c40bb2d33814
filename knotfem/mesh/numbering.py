"""From loose nodes and quadrilaterals of a unit disc to a `Section`: numbered from the axis outwards, and checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.mesh.section import Section, regular_polygon
from knotfem.mesh.section_properties import area

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

EXACT = 1e-9
"""Deviation from the unit circle, in radii, of a section that is taken as it is."""


def number_section(points: FloatArray, quads: IntArray, file: Path | None = None) -> Section:
    """Number nodes by radius and angle and quadrilaterals by their first node, all counter-clockwise.

    Args:
        points: node positions in units of the radius, shape (m, 2); those that no quadrilateral uses are dropped.
        quads: nodes of each quadrilateral in the order of its outline, shape (q, 4).
        file: that they come from, for messages.

    Raises:
        InputError: a quadrilateral is not convex, the boundary is not one closed loop of nodes on the unit circle at
            equal angles from 0 on, there is no node at the origin, or the disc is not filled once.
    """
    used = np.unique(quads)
    points = points[used]
    radius, angle = np.hypot(*points.T), np.mod(np.arctan2(points[:, 1], points[:, 0]), 2 * np.pi)
    angle[(radius < EXACT) | (angle > 2 * np.pi - EXACT)] = 0.0
    order = np.lexsort((angle, np.round(radius, 9)))
    number = np.empty(used[-1] + 1, dtype=np.int64)
    number[used[order]] = np.arange(len(used))
    points, quads = points[order], number[quads]

    signed = signed_areas(points, quads)
    quads = np.where(signed[:, None] < 0, quads[:, ::-1], quads)
    if len(bad := bent_quads(points, quads)):
        raise InputError("a quadrilateral is not convex", file=file, found=f"{len(bad)} of {len(quads)}")
    start = np.argmin(quads, axis=1)
    quads = np.take_along_axis(quads, (start[:, None] + np.arange(4)) % 4, axis=1)
    quads = quads[np.lexsort(quads.T[::-1])]

    if np.hypot(*points[0]) > EXACT:
        raise InputError("a cross-section has a node at the origin, on the rod's axis", file=file)
    ring = outline(points, quads, file)
    error = float(np.abs(points[ring] - regular_polygon(len(ring))).max())
    if error > EXACT:
        raise InputError(
            "boundary nodes lie on the unit circle at equal angles, the first at angle 0",
            file=file,
            found=f"a distance of {error:.3g} from there",
        )
    section = Section(points, quads, 0, ring)
    if abs(np.abs(signed).sum() - area(section)) > EXACT:
        raise InputError("the quadrilaterals do not fill the disc once", file=file)
    return section


def signed_areas(points: FloatArray, quads: IntArray) -> FloatArray:
    """Area of each quadrilateral, negative for a clockwise one, shape (q,)."""
    corners = points[quads]
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def bent_quads(points: FloatArray, quads: IntArray) -> IntArray:
    """Numbers of the counter-clockwise quadrilaterals that are not convex, having a corner of 180 degrees or more."""
    edges = np.roll(points[quads], -1, axis=1) - points[quads]
    before = np.roll(edges, 1, axis=1)
    turn = before[..., 0] * edges[..., 1] - before[..., 1] * edges[..., 0]
    return np.flatnonzero((turn <= 0).any(axis=1))


def boundary_edges(quads: IntArray) -> IntArray:
    """Edges that no other quadrilateral has in the opposite direction, as their own one runs along them.

    Args:
        quads: counter-clockwise, shape (q, 4).

    Returns:
        First and last node, ascending, shape (n, 2).
    """
    known = {(a, b) for a, b in _edges(quads).tolist()}
    return np.array(sorted(edge for edge in known if edge[::-1] not in known), dtype=np.int64).reshape(-1, 2)


def outline(points: FloatArray, quads: IntArray, file: Path | None = None) -> IntArray:
    """Boundary nodes in counter-clockwise order, from the one furthest along x.

    Args:
        points: node positions, shape (m, 2).
        quads: counter-clockwise, shape (q, 4).
        file: that they come from, for messages.

    Raises:
        InputError: an edge belongs to more than two quadrilaterals, or the boundary is not one closed loop.
    """
    directed, uses = np.unique(_edges(quads), axis=0, return_counts=True)
    if (uses > 1).any():
        a, b = directed[np.argmax(uses)]
        raise InputError(
            "an edge belongs to at most two quadrilaterals",
            file=file,
            found=f"overlapping ones at the edge {said(points[a])} - {said(points[b])}",
            expected="each quadrilateral once",
        )
    boundary = boundary_edges(quads)
    following: dict[int, int] = dict(boundary.tolist())
    first = max(following, key=lambda node: points[node, 0], default=0)
    ring = [first]
    while len(ring) <= len(following) and (node := following.get(ring[-1], first)) != first:
        ring.append(node)
    if len(following) < len(boundary) or len(ring) < 3 or len(ring) != len(boundary):
        others = np.setdiff1d(boundary[:, 0], ring)
        stray = others if others.size else boundary[:, 0]
        raise InputError(
            "the boundary of a cross-section is one closed loop",
            file=file,
            found=f"another boundary at {said(points[stray[0]])}",
            expected="no hole, no slit, one piece",
        )
    return np.array(ring, dtype=np.int64)


def _edges(quads: IntArray) -> IntArray:
    """First and last node of the edges of each quadrilateral, in the direction of its outline, shape (4 q, 2)."""
    return np.column_stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()])


def said(point: FloatArray) -> str:
    """A place in words."""
    return f"({point[0]:.6g}, {point[1]:.6g})"
