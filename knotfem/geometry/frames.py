"""Tangents, orthonormal frames and twist of a polyline.

A frame is an array of shape (3, 3) with the orthonormal rows d1, d2 and t: two directors in the cross-section and the
tangent, d2 = t x d1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from knotfem.compiled import kernel
from knotfem.errors import InputError
from knotfem.geometry.points import as_points
from knotfem.geometry.rotation import cross
from knotfem.geometry.vectors import perpendicular, unit, unit_edges
from knotfem.types import Array

FOLD = 1e-9
"""Two successive edges whose unit vectors have a sum shorter than this fold back onto each other."""


def tangents(points: ArrayLike) -> Array:
    """Unit tangents at the vertices of a polyline.

    At an inner vertex the tangent bisects the directions of the two edges. At an end it is the mirror image of the
    neighbouring tangent in the plane perpendicular to the last edge at its midpoint. Both are exact for equal chords of
    a circle.

    Args:
        points: shape (n, 3).

    Returns:
        Shape (n, 3).

    Raises:
        InputError: points that `as_points` refuses, or two edges that fold back onto each other.
    """
    x = as_points(points)
    edge = unit_edges(x)
    t = np.empty_like(x)
    t[1:-1] = edge[1:] + edge[:-1]
    length = np.linalg.norm(t[1:-1], axis=1)
    if (length < FOLD).any():
        raise InputError(f"the polyline folds back at point {int(np.argmin(length)) + 2}")
    t[1:-1] /= length[:, None]
    if len(x) == 2:
        t[:] = edge[0]
        return t
    t[0] = 2.0 * (edge[0] @ t[1]) * edge[0] - t[1]
    t[-1] = 2.0 * (edge[-1] @ t[-2]) * edge[-1] - t[-2]
    return t


def material_frames(tangents: ArrayLike, directors: ArrayLike) -> Array:
    """Orthonormal frames from tangents and one director of each cross-section.

    Args:
        tangents: unit vectors, shape (n, 3).
        directors: projected onto the plane perpendicular to the tangent and scaled to length 1, shape (n, 3).

    Returns:
        Rows d1, d2, t, shape (n, 3, 3).

    Raises:
        InputError: a director along its tangent.
    """
    t, d = np.asarray(tangents, dtype=np.float64), np.asarray(directors, dtype=np.float64)
    across = d - np.einsum("ij,ij->i", d, t)[:, None] * t
    length = np.linalg.norm(across, axis=1)
    along = np.flatnonzero(~(length > 1e-9 * np.linalg.norm(d, axis=1)))
    if along.size:
        raise InputError(f"director {along[0] + 1} lies along the tangent", found=d[along[0]].tolist())
    d1 = across / length[:, None]
    return np.stack([d1, np.cross(t, d1), t], axis=1)


def rotation_minimising_frame(points: ArrayLike, start: ArrayLike | None = None) -> Array:
    """Frames without twist at the vertices of a polyline, by double reflection.

    Source: Wang, Juettler, Zheng and Liu, ACM Trans. Graph. 27, 2 (2008); fourth order in the spacing.

    Args:
        points: shape (n, 3).
        start: direction of d1 at the first vertex, projected onto the cross-section there, shape (3,). If it is given,
            a rigid motion of points and start moves the frames likewise. None takes the coordinate axis that makes the
            largest angle with the first tangent (e_x for a rod along e_z).

    Returns:
        Rows d1, d2, t at each vertex, shape (n, 3, 3).

    Raises:
        InputError: points that `tangents` refuses, or a start along the tangent.
    """
    x = as_points(points)
    t = tangents(x)
    if start is None:
        return _double_reflection(x, t, perpendicular(t[0]))
    seed = unit(start)
    across = seed - (seed @ t[0]) * t[0]
    if np.linalg.norm(across) < 1e-9:
        raise InputError("the frame's first direction lies along the rod", found=seed.tolist())
    return _double_reflection(x, t, unit(across))


@kernel
def _reflect_twice(d: Array, chord: Array, t: Array, t_next: Array) -> Array:
    """Carry d from a vertex to the next, chord apart: reflect it along the chord, then so that the tangents agree."""
    c = 2.0 / np.dot(chord, chord)
    half = d - c * np.dot(chord, d) * chord
    w = t_next - (t - c * np.dot(chord, t) * chord)
    norm = np.dot(w, w)
    if norm > 0.0:
        half = half - (2.0 / norm) * np.dot(w, half) * w
    half = half - np.dot(half, t_next) * t_next
    return half / np.sqrt(np.dot(half, half))


@kernel
def _double_reflection(x: Array, t: Array, start: Array) -> Array:
    frames = np.empty((len(x), 3, 3))
    d = start.copy()
    for i in range(len(x)):
        if i > 0:
            d = _reflect_twice(d, x[i] - x[i - 1], t[i - 1], t[i])
        frames[i, 0] = d
        cross(t[i], d, frames[i, 1])
        frames[i, 2] = t[i]
    return frames


def rotate_frames(frames: ArrayLike, angles: ArrayLike) -> Array:
    """Rotate each frame about its own tangent.

    Args:
        frames: rows d1, d2, t, shape (n, 3, 3).
        angles: rad, positive from d1 to d2, shape (n,) or one number.

    Returns:
        Shape (n, 3, 3).
    """
    f = np.asarray(frames, dtype=np.float64)
    angle = np.broadcast_to(np.asarray(angles, dtype=np.float64), (len(f),))
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack([c * f[:, 0] + s * f[:, 1], c * f[:, 1] - s * f[:, 0], f[:, 2]], axis=1)


def twist_of(frames: ArrayLike, points: ArrayLike | None = None) -> Array:
    """Twist from each frame to the next: the angle from d1, carried along without twist, to the next d1.

    Args:
        frames: rows d1, d2, t, shape (n, 3, 3).
        points: vertices, shape (n, 3). If they are given, d1 is carried by double reflection, and a rotation-minimising
            frame has no twist at all. None carries it by the smallest rotation that aligns the tangents.

    Returns:
        rad, positive from d1 to d2, in (-pi, pi], shape (n - 1,).

    Raises:
        InputError: another number of points than of frames.
    """
    f = np.ascontiguousarray(frames, dtype=np.float64)
    t, u = f[:-1, 2], f[1:, 2]
    chord = t + u if points is None else np.diff(as_points(points), axis=0)
    if len(chord) != len(f) - 1:
        raise InputError("frames and points differ in number", found=len(chord) + 1, expected=f"{len(f)} points")
    return _twist(f, np.ascontiguousarray(chord))


@kernel
def _twist(f: Array, chord: Array) -> Array:
    twist = np.empty(len(chord))
    for i in range(len(chord)):
        d = _reflect_twice(f[i, 0], chord[i], f[i, 2], f[i + 1, 2])
        twist[i] = math.atan2(-np.dot(d, f[i + 1, 1]), np.dot(d, f[i + 1, 0]))
    return twist
