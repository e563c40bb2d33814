"""Arclength, turning angles and curvature of a polyline, and means over its edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.points import as_points
from knotfem.geometry.vectors import angles_between, unit_edges
from knotfem.types import Array


def arclength(points: ArrayLike) -> Array:
    """Length of the polyline from its first point to each point.

    Args:
        points: shape (n, 3).

    Returns:
        In the units of the points, shape (n,).

    Raises:
        InputError: points that `as_points` refuses; the same holds for the other functions of this module.
    """
    x = as_points(points)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])


def vertex_means(edges: Array) -> Array:
    """Means of values on the edges of a polyline at its vertices; an end takes the value of its one edge.

    Args:
        edges: shape (n, ...).

    Returns:
        Shape (n + 1, ...).
    """
    return np.concatenate([edges[:1], 0.5 * (edges[1:] + edges[:-1]), edges[-1:]])


def turning_angles(points: ArrayLike) -> Array:
    """Angle between the two edges that meet at each inner point.

    Args:
        points: shape (n, 3).

    Returns:
        rad, shape (n - 2,).
    """
    edge = unit_edges(as_points(points))
    return angles_between(edge[1:], edge[:-1])


def curvature(points: ArrayLike) -> Array:
    """Curvature at the points: 2 sin(angle / 2) over the mean length of the two edges, exact for chords of a circle.

    The first and the last point take the value of their neighbour.

    Args:
        points: shape (n, 3), mm.

    Returns:
        1/mm, shape (n,).
    """
    x = as_points(points)
    if len(x) == 2:
        return np.zeros(2)
    size = np.linalg.norm(np.diff(x, axis=0), axis=1)
    inner = 2.0 * np.sin(0.5 * turning_angles(x)) / (0.5 * (size[1:] + size[:-1]))
    return np.concatenate([inner[:1], inner, inner[-1:]])
