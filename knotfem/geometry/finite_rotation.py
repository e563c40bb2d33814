"""Finite rotations and parallel transport of NumPy arrays, for all code outside compiled kernels.

Rotations are right-handed and turn vectors, not coordinate axes. `scipy.spatial.transform.Rotation` composes and
applies them. The kernels of `knotfem.geometry.rotation` are the same formulas for single vectors in compiled loops;
`parallel_transport` runs on them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from knotfem.compiled import kernel
from knotfem.errors import InputError
from knotfem.geometry.rotation import transport
from knotfem.types import Array

OPPOSITE = 1e-6
"""Two unit vectors whose sum is shorter than this count as opposite: no smallest rotation takes one to the other. A
formula with 1/(1 + a . b) has lost all but four digits there."""

PERPENDICULAR = 1e-6
"""Largest cosine of the angle between a director and its tangent."""


def rotate(vectors: ArrayLike, axis: ArrayLike, angles: ArrayLike) -> Array:
    """Rotate vectors about an axis through the origin (Rodrigues' formula).

    The three arguments broadcast against each other: one rotation of many vectors, many rotations of one vector, or
    one rotation for each vector.

    Args:
        vectors: shape (..., 3).
        axis: of any length but zero, shape (..., 3).
        angles: rad, right-handed about the axis, shape (...).

    Returns:
        Shape (..., 3).

    Raises:
        InputError: an axis of length zero, or one that is not finite.
    """
    v, along = np.asarray(vectors, dtype=np.float64), np.asarray(axis, dtype=np.float64)
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    if not (np.isfinite(length).all() and (length > 0.0).all()):
        raise InputError("not an axis of rotation", found=along.tolist(), expected="finite vectors other than zero")
    rotation_vectors = np.asarray(angles, dtype=np.float64)[..., None] * (along / length)
    if rotation_vectors.ndim == 1:
        return Rotation.from_rotvec(rotation_vectors).apply(v.reshape(-1, 3)).reshape(v.shape)
    rotation_vectors, v = (array.copy() for array in np.broadcast_arrays(rotation_vectors, v))
    return Rotation.from_rotvec(rotation_vectors.reshape(-1, 3)).apply(v.reshape(-1, 3)).reshape(v.shape)


def smallest_rotation(start: ArrayLike, end: ArrayLike) -> Rotation:
    """The rotation by the smallest angle that takes each unit vector `start` to `end`.

    Its axis is a x b and its angle that between a and b. As a quaternion it is (a x m, a . m) with the unit vector m
    halfway between a and b.

    Args:
        start: a, shape (3,) or (n, 3).
        end: b, same shape.

    Returns:
        One rotation, or n of them; `apply` rotates vectors.

    Raises:
        InputError: two vectors are opposite, so that all axes perpendicular to them would do.
    """
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    middle = a + b
    length = np.linalg.norm(middle, axis=-1, keepdims=True)
    _refuse_opposite(length)
    middle = middle / length
    return Rotation.from_quat(np.concatenate([np.cross(a, middle), (a * middle).sum(axis=-1, keepdims=True)], axis=-1))


def parallel_transport(tangents: ArrayLike, director: ArrayLike) -> Array:
    """Carry a director along a sequence of tangents, from each to the next by the smallest rotation.

    Along the edges of a polyline this is discrete parallel transport: the carried directors have no twist.
    Source: Bergou, Wardetzky, Robinson, Audoly and Grinspun, ACM Trans. Graph. 27, 63 (2008).

    Args:
        tangents: unit vectors, shape (n, 3).
        director: at the first tangent and perpendicular to it, shape (3,).

    Returns:
        Directors, each perpendicular to its tangent, shape (n, 3); the first is the one given.

    Raises:
        InputError: two successive tangents are opposite, or the director is not perpendicular to the first tangent.
    """
    t, d = np.ascontiguousarray(tangents, dtype=np.float64), np.asarray(director, dtype=np.float64)
    cosine = abs(float(t[0] @ d))
    if not cosine <= PERPENDICULAR:
        raise InputError("the director is not perpendicular to the first tangent", found=cosine, expected="cosine 0")
    _refuse_opposite(np.linalg.norm(t[1:] + t[:-1], axis=1))
    directors = np.empty_like(t)
    directors[0] = d
    _transport_along(t, directors)
    return directors


@kernel
def _transport_along(tangents: Array, directors: Array) -> None:
    for i in range(1, len(tangents)):
        transport(tangents[i - 1], tangents[i], directors[i - 1], directors[i])


def half_binormals(start: ArrayLike, end: ArrayLike) -> Array:
    """Half the curvature binormal of each pair of edges: k = a x b/(1 + a . b), of size tan(angle / 2).

    Source: Bergou et al., ACM Trans. Graph. 27, 63 (2008), Eq. (1), which defines twice this vector.

    Args:
        start: unit vectors a, shape (n, 3).
        end: unit vectors b, shape (n, 3).

    Returns:
        Shape (n, 3).

    Raises:
        InputError: two vectors are opposite.
    """
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    _refuse_opposite(np.linalg.norm(a + b, axis=-1))
    return np.cross(a, b) / (1.0 + np.einsum("...i,...i->...", a, b)[..., None])


def rotation_vector(before: ArrayLike, after: ArrayLike) -> Array:
    """Rotation that takes one orthonormal frame to another, as axis times angle.

    Args:
        before: three unit vectors as rows, shape (3, 3) or (n, 3, 3).
        after: the same vectors after the rotation, same shape.

    Returns:
        rad, at most pi long, shape (3,) or (n, 3).
    """
    first, second = np.asarray(before, dtype=np.float64), np.asarray(after, dtype=np.float64)
    return Rotation.from_matrix(np.swapaxes(second, -1, -2) @ first).as_rotvec()


def _refuse_opposite(length: Array) -> None:
    """Raise InputError where a sum of two unit vectors, of the given length, is nearly zero."""
    if (length < OPPOSITE).any():
        raise InputError("two directions are opposite: no smallest rotation takes one to the other")
