"""Surfaces to look at: smooth tubes through the boundary nodes, or the boundary quadrilaterals themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.mesh.rod import side_quads
from knotfem.types import Array, Index

_AROUND = 48
_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


@dataclass(frozen=True, eq=False)
class Surface:
    """Polygons with a value on each point.

    Attributes:
        points: positions in mm, shape (p, 3).
        faces: points of each polygon, normals outwards, shape (f, 4); a triangle repeats its last point.
        values: scalar to colour by, shape (p,), or none.
    """

    points: Array
    faces: Index
    values: Array | None = None


def smooth_tube(rings: Array, values: Array | None = None) -> Surface:
    """Round a rod's facets: a trigonometric curve around through the boundary nodes, a cubic spline along.

    A regular polygon becomes its circle. Values are interpolated linearly, so that no colour
    shows a value that is not there.

    Args:
        rings: boundary nodes of each section in mm, shape (n + 1, k, 3).
        values: scalar on them, shape (n + 1, k).
    """
    from scipy.interpolate import CubicSpline
    from scipy.signal import resample

    stations, k, _ = rings.shape
    width = float(np.linalg.norm(rings[0] - rings[0].mean(axis=0), axis=1).mean())
    spacing = float(np.linalg.norm(np.diff(rings.mean(axis=1), axis=0), axis=1).max())
    along = max(1, int(np.ceil(2 * spacing / width)))
    around = -(-_AROUND // k)
    s = np.arange(stations)
    fine = np.linspace(0, stations - 1, (stations - 1) * along + 1)
    points = CubicSpline(s, np.asarray(resample(rings, around * k, axis=1)))(fine)
    rows, columns = points.shape[:2]
    side = side_quads(np.arange(rows * columns).reshape(rows, columns))
    first, last = (np.vstack([row, row.mean(axis=0)]) for row in (points[0], points[-1]))
    start = rows * columns
    caps = np.concatenate([_fan(columns, start)[:, [1, 0, 2, 2]], _fan(columns, start + columns + 1)])
    surface = np.concatenate([points.reshape(-1, 3), first, last])
    if values is None:
        return Surface(surface, np.concatenate([side, caps]))
    part = np.arange(columns) / around
    low = np.floor(part).astype(int)
    round_values = values[:, low] * (1 - part + low) + values[:, (low + 1) % k] * (part - low)
    near = np.minimum(fine.astype(int), max(stations - 2, 0))
    weight = (fine - near)[:, None]
    grid = round_values[near] * (1 - weight) + round_values[near + 1] * weight
    ends = (np.append(row, row.mean()) for row in (grid[0], grid[-1]))
    return Surface(surface, np.concatenate([side, caps]), np.concatenate([grid.ravel(), *ends]))


def boundary(points: Array, hexes: Index, values: Array | None = None) -> Surface:
    """Faces of hexahedra that no neighbour shares.

    Args:
        points: positions in mm, shape (N, 3).
        hexes: nodes of each hexahedron in VTK order, shape (E, 8) or (E, 27).
        values: scalar on the nodes, shape (N,).
    """
    faces = hexes[:, _FACES].reshape(-1, 4)
    _, which, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    outer = faces[count[which.ravel()] == 1]
    used, compact = np.unique(outer, return_inverse=True)
    return Surface(points[used], compact.reshape(-1, 4), None if values is None else values[used])


def on_nodes(hexes: Index, values: Array, nodes: int) -> Array:
    """Mean over the hexahedra around each node of values on hexahedra; zero at a node of none.

    Args:
        hexes: nodes of each hexahedron, shape (E, 8) or (E, 27).
        values: one a hexahedron, shape (E,).
        nodes: number of nodes.
    """
    total = np.bincount(hexes.ravel(), weights=np.repeat(values, hexes.shape[1]), minlength=nodes)
    return total / np.maximum(np.bincount(hexes.ravel(), minlength=nodes), 1)


def _fan(columns: int, start: int) -> Index:
    edge = start + np.arange(columns)
    return np.column_stack([edge, np.roll(edge, -1), *[np.full(columns, start + columns)] * 2])
