"""Cross-sections from outside: checked one by one for what a rod needs, and brought to the unit disc.

A disc of any size may lie anywhere in any plane. The smooth surface on which contact acts is a spline over the
boundary nodes (`knotfem.contact`), round only where these stand on a circle at equal angles; and the core and the
centreline need a node on the axis. Deviations up to `TOLERANCE` are taken for rounding and set right.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.vectors import perpendicular
from knotfem.mesh.numbering import EXACT, bent_quads, boundary_edges, outline, said, signed_areas
from knotfem.mesh.section import regular_polygon

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

TOLERANCE = 1e-3
"""Of boundary and axis nodes and of the plane, in radii."""
_COINCIDENT = 1e-6
"""Distance of two nodes in one place, over the size of the section."""


def unit_disc(points: FloatArray, quads: IntArray, file: Path) -> tuple[FloatArray, IntArray]:
    """The section with its centre at the origin, radius 1 and a boundary node at angle 0.

    A section that is so already to `EXACT` is not changed in any bit.

    Args:
        points: node positions, shape (m, 2) or (m, 3), in any unit of length.
        quads: nodes of each quadrilateral in the order of its outline, shape (q, 4).
        file: that they come from, for messages.

    Returns:
        Positions of the used nodes, shape (n, 2), and the quadrilaterals, counter-clockwise, shape (q, 4).

    Raises:
        InputError: what is wrong, where, and its cure.
    """
    used, quads = np.unique(quads, return_inverse=True)
    quads = quads.reshape(-1, 4).astype(np.int64)
    points = points[used]
    if not np.isfinite(points).all():
        raise InputError("node positions are not finite", file=file, expected="numbers")
    flat = _flatten(points, file)
    _refuse_coincident(flat, file)
    quads = np.where(signed_areas(flat, quads)[:, None] < 0, quads[:, ::-1], quads)
    if len(bad := bent_quads(flat, quads)):
        raise InputError(
            "a quadrilateral is not convex",
            file=file,
            found=f"{len(bad)} of {len(quads)}, the first around {said(flat[quads[bad[0]]].mean(axis=0))}",
            expected="four corners of less than 180 degrees each: another mesh",
        )
    _refuse_hanging(flat, quads, file)
    ring = outline(flat, quads, file)
    return _normalised(flat, ring, file), quads


def _flatten(points: FloatArray, file: Path) -> FloatArray:
    """Coordinates in the plane of the section: x and y where it lies in z = constant."""
    if points.shape[1] == 2:
        return points.copy()
    size = float(np.ptp(points, axis=0).max())
    if np.ptp(points[:, 2]) <= EXACT * size:
        return points[:, :2].copy()
    offset = points - points.mean(axis=0)
    normal = np.linalg.svd(offset, full_matrices=False)[2][2]
    away = float(np.abs(offset @ normal).max())
    if away > 0.5 * TOLERANCE * size:
        raise InputError(
            "the quadrilaterals of a cross-section lie in one plane",
            file=file,
            found=f"a node {away:.3g} off it",
            expected=f"at most {0.5 * TOLERANCE * size:.3g}: the mesh of a face, not of a surface in space",
        )
    normal = normal * np.sign(normal[np.argmax(np.abs(normal))])
    first = perpendicular(normal)
    return np.column_stack([offset @ first, offset @ np.cross(normal, first)])


def _refuse_coincident(points: FloatArray, file: Path) -> None:
    from scipy.spatial import KDTree

    size = float(np.ptp(points, axis=0).max())
    pairs = KDTree(points).query_pairs(_COINCIDENT * size, output_type="ndarray")
    if len(pairs):
        raise InputError(
            "two nodes in one place",
            file=file,
            found=f"{len(pairs)} such pairs, the first at {said(points[pairs[0, 0]])}",
            expected='nodes that neighbouring quadrilaterals share (in gmsh: "Coherence Mesh")',
        )


def _refuse_hanging(points: FloatArray, quads: IntArray, file: Path) -> None:
    """Nodes in the middle of an edge that does not know them."""
    boundary = boundary_edges(quads)
    nodes = np.unique(boundary)
    start, along = points[boundary[:, 0]], points[boundary[:, 1]] - points[boundary[:, 0]]
    length = np.linalg.norm(along, axis=1)
    offset = points[nodes][:, None] - start
    part = np.einsum("nei,ei->ne", offset, along) / length**2
    away = np.abs(offset[..., 0] * along[:, 1] - offset[..., 1] * along[:, 0]) / length
    hanging = (away < _COINCIDENT * length) & (part > _COINCIDENT) & (part < 1.0 - _COINCIDENT)
    if hanging.any():
        node, _ = np.argwhere(hanging)[0]
        raise InputError(
            "a node hangs on the edge of a quadrilateral that does not have it",
            file=file,
            found=f"{np.count_nonzero(hanging.any(axis=1))} such nodes, the first at {said(points[nodes[node]])}",
            expected="quadrilaterals that meet edge to edge: the same number of divisions on both sides",
        )


def _normalised(points: FloatArray, ring: IntArray, file: Path) -> FloatArray:
    """Centre, scale and turn the disc; boundary and axis nodes are set exactly."""
    circle = regular_polygon(len(ring))
    if np.abs(points[ring] - circle).max() <= EXACT and np.hypot(*points.T).min() <= EXACT:
        return points
    centre, radius = _circle_through(points[ring])
    offset = points - centre
    distance = np.hypot(*offset.T)
    error = np.abs(distance[ring] - radius)
    if (worst := int(np.argmax(error))) >= 0 and error[worst] > TOLERANCE * radius:
        raise InputError(
            "the boundary of a cross-section is a circle",
            file=file,
            found=f"a node at {said(points[ring[worst]])}, {distance[ring[worst]]:.6g} from the centre {said(centre)}",
            expected=f"a distance of {radius:.6g}, to {TOLERANCE:g} of it, of every boundary node",
        )
    _refuse_uneven(offset[ring], points[ring], file)
    axis = int(np.argmin(distance))
    if distance[axis] > TOLERANCE * radius:
        raise InputError(
            "a cross-section has a node on the rod's axis",
            file=file,
            found=f"the nearest at {said(points[axis])}, {distance[axis]:.6g} away",
            expected=f"a node at the centre of the circle, {said(centre)} (in gmsh: a point embedded there)",
        )
    return _turned(offset / radius, ring, axis, circle)


def _circle_through(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre and radius of the circle nearest to points in the sense of Kasa: least squares of x^2 + y^2."""
    middle = points.mean(axis=0)
    p = points - middle
    system = np.column_stack([2.0 * p, np.ones(len(p))])
    a, b, c = np.linalg.lstsq(system, (p**2).sum(axis=1), rcond=None)[0]
    return middle + np.array([a, b]), float(np.sqrt(c + a * a + b * b))


def _refuse_uneven(ring: FloatArray, places: FloatArray, file: Path) -> None:
    angle = np.unwrap(np.arctan2(ring[:, 1], ring[:, 0]))
    steps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
    even = 2 * np.pi / len(ring)
    worst = int(np.argmax(np.abs(steps - even)))
    if abs(steps[worst] - even) > TOLERANCE:
        raise InputError(
            "boundary nodes of a cross-section stand at equal angles",
            file=file,
            found=f"a step of {np.degrees(steps[worst]):.4g} degrees from {said(places[worst])}",
            expected=f"{np.degrees(even):.4g} degrees between each two (in gmsh: a transfinite curve)",
        )


def _turned(offset: FloatArray, ring: IntArray, axis: int, circle: FloatArray) -> FloatArray:
    """Turned by the smallest angle that brings a boundary node to angle 0."""
    z = offset[:, 0] + 1j * offset[:, 1]
    step = 2 * np.pi / len(ring)
    phase = np.angle(np.mean(np.exp(1j * len(ring) * np.angle(z[ring])))) / len(ring)
    if abs(phase) > EXACT:
        z = z * np.exp(-1j * phase)
    place = np.round(np.mod(np.angle(z[ring]), 2 * np.pi) / step).astype(np.int64) % len(ring)
    found = np.column_stack([z.real, z.imag])
    found[ring], found[axis] = circle[place], 0.0
    return found
