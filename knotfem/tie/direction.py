"""Directions of the straight rod from which no edge of the knot has to turn far."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import nnls
from scipy.spatial import ConvexHull, QhullError

from knotfem.errors import InputError
from knotfem.tie.path import Array, check_direction


def largest_angle(tangents: Array, direction: Array) -> float:
    """Returns the largest angle between the direction and the tangents (n, 3), rad."""
    cross = np.linalg.norm(np.cross(tangents, direction), axis=1)
    return float(np.arctan2(cross, tangents @ direction).max())


def best_direction(tangents: Array) -> Array:
    """Returns the direction whose largest angle to the tangents is smallest, shape (3,).

    Args:
        tangents: unit edge vectors of the target, shape (n, 3).
    """
    return candidate_directions(tangents, 1)[0]


def candidate_directions(tangents: Array, count: int, apart: float = 0.35) -> Array:
    """Returns centres of the largest caps of the sphere that hold no reversed tangent, best first.

    The largest angle between E and the tangents is pi less the radius of the largest empty cap round -E. Where the
    tangents lie in no hemisphere the centres of empty caps are the normals of the facets of their convex hull; where
    they do, the best E is the point of the hull nearest the origin (least-distance programming, Lawson and Hanson).

    Args:
        tangents: unit vectors, shape (n, 3).
        count: largest number of directions.
        apart: smallest angle between two of them, rad.

    Returns:
        Unit vectors, shape (<= count, 3).
    """
    weights, residual = nnls(np.vstack([tangents.T, np.ones(len(tangents))]), np.array([0.0, 0.0, 0.0, 1.0]))
    if residual > 1e-6:
        nearest = tangents.T @ weights
        return (nearest / np.linalg.norm(nearest))[None]
    try:
        hull = ConvexHull(tangents)
    except QhullError:
        normal = np.linalg.svd(tangents, full_matrices=False)[2][-1]
        return np.array([normal, -normal])[:count]
    order = np.argsort(hull.equations[:, 3])[::-1]
    chosen: list[Array] = []
    for direction in -hull.equations[order, :3]:
        if all(direction @ other < np.cos(apart) for other in chosen):
            chosen.append(direction)
            if len(chosen) == count:
                break
    return np.array(chosen)


def resolve_direction(direction: str | ArrayLike, target: Array) -> Array:
    """Returns the straight rod's direction as a unit vector, shape (3,).

    Args:
        direction: a vector, or "best" for `best_direction` of the target's edges.
        target: vertices, shape (n + 1, 3).

    Raises:
        InputError: neither "best" nor three finite numbers, not all zero.
    """
    if isinstance(direction, str):
        if direction != "best":
            raise InputError("wrong direction of the straight rod", found=direction, expected="'best' or a vector")
        edges = np.diff(target, axis=0)
        return best_direction(edges / np.linalg.norm(edges, axis=1, keepdims=True))
    return check_direction(direction)
