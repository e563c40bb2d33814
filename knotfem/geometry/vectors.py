"""Directions and angles of vectors in NumPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.types import Array


def unit(vector: ArrayLike) -> Array:
    """Return the vector, shape (3,), scaled to length 1.

    Raises:
        InputError: its length is zero or not finite.
    """
    array = np.asarray(vector, dtype=np.float64)
    length = float(np.linalg.norm(array)) if array.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise InputError("not a direction", found=array.tolist(), expected="three finite numbers, not all zero")
    return array / length


def unit_vectors(vectors: Array) -> Array:
    """Vectors scaled to length 1.

    Args:
        vectors: none of length zero, shape (n, 3).

    Returns:
        Shape (n, 3).
    """
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def unit_edges(points: Array) -> Array:
    """Unit vectors along the edges of a polyline.

    Args:
        points: vertices, shape (n + 1, 3), no two neighbours the same.

    Returns:
        Shape (n, 3).
    """
    return unit_vectors(np.diff(points, axis=0))


def perpendicular(direction: Array) -> Array:
    """One of the unit vectors perpendicular to a direction.

    It is the coordinate axis that makes the largest angle with the direction, made perpendicular to it: e_x for a
    direction along e_z. Axes whose components differ by less than 1e-9 count as equal, and the first of them is taken,
    so that rounding does not decide.

    Args:
        direction: unit vector, shape (3,).

    Returns:
        Shape (3,).
    """
    axis = np.eye(3)[int(np.argmin(np.abs(direction).round(9)))]
    across = axis - (axis @ direction) * direction
    return across / np.linalg.norm(across)


def from_axis(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> Array:
    """Vectors from an axis to points, perpendicular to it; their lengths are the distances from the axis.

    Args:
        points: shape (n, 3), mm.
        point: any point of the axis, shape (3,), mm.
        axis: its direction, shape (3,), of any length.

    Returns:
        mm, shape (n, 3).

    Raises:
        InputError: an axis of length zero.
    """
    along = unit(axis)
    vectors = np.asarray(points, dtype=np.float64) - np.asarray(point, dtype=np.float64)
    return vectors - np.outer(vectors @ along, along)


def along_and_across(vectors: Array, directions: Array) -> tuple[Array, Array]:
    """Components of vectors along unit vectors, and sizes of what is perpendicular to these.

    Args:
        vectors: shape (n, 3).
        directions: unit vectors, shape (n, 3).

    Returns:
        Two arrays of shape (n,).
    """
    along = np.einsum("ni,ni->n", vectors, directions)
    return along, np.linalg.norm(vectors - along[:, None] * directions, axis=1)


def angles_between(first: Array, second: Array) -> Array:
    """Angles between pairs of unit vectors, accurate for nearly equal and nearly opposite ones alike.

    angle = 2 atan2(|a - b|, |a + b|).
    Source: Kahan, "How futile are mindless assessments of roundoff in floating-point computation?" (2006).

    Args:
        first: shape (..., 3).
        second: shape (..., 3).

    Returns:
        rad, between 0 and pi, shape (...).
    """
    return 2.0 * np.arctan2(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1))
