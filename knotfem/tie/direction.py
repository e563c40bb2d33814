"""Directions of the straight rod for which no edge has to rotate by a large angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import nnls
from scipy.spatial import ConvexHull, QhullError

from knotfem.errors import InputError
from knotfem.geometry.vectors import unit, unit_edges
from knotfem.types import Array


def best_direction(tangents: Array) -> Array:
    """Return the unit vector whose largest angle to the tangents is smallest, shape (3,).

    Args:
        tangents: unit edge vectors of the target, shape (n, 3).
    """
    return candidate_directions(tangents, 1)[0]


def candidate_directions(tangents: Array, count: int, apart: float = 0.35) -> Array:
    """Return directions with small largest angles to the tangents, the smallest first.

    The largest angle between E and the tangents is pi minus the radius of the largest cap of the unit sphere about -E
    that contains no tangent. If the tangents lie in no common hemisphere, the centres of the largest empty caps are the
    outward normals of the facets of their convex hull. If they do, the best E points to the point of the hull nearest
    to the origin (least-distance programming; Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23).

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
    """Return the direction of the straight rod as a unit vector, shape (3,).

    Args:
        direction: a vector of any length, or "best" for `best_direction` of the target's edges.
        target: vertices, shape (n + 1, 3).

    Raises:
        InputError: neither "best" nor three finite numbers, not all zero.
    """
    if isinstance(direction, str):
        if direction != "best":
            raise InputError("wrong direction of the straight rod", found=direction, expected="'best' or a vector")
        return best_direction(unit_edges(target))
    return unit(direction)
