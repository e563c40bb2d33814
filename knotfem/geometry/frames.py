"""Tangents, rotation-minimising frames, twist and writhe of a polyline."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from knotfem.compiled import kernel
from knotfem.errors import InputError
from knotfem.geometry.points import Array, as_points, unit


def tangents(points: ArrayLike) -> Array:
    """Unit tangents at the nodes: bisecting the edges inside, mirrored across the edge at both ends.

    Exact for equal chords of a circle.

    Args:
        points: shape (n, 3).

    Returns:
        Shape (n, 3).

    Raises:
        InputError: points that `as_points` refuses, or two edges that fold back onto each other.
    """
    x = as_points(points)
    edge = np.diff(x, axis=0)
    edge /= np.linalg.norm(edge, axis=1)[:, None]
    t = np.empty_like(x)
    t[1:-1] = edge[1:] + edge[:-1]
    length = np.linalg.norm(t[1:-1], axis=1)
    if (length < 1e-9).any():
        raise InputError(f"the polyline folds back at point {int(np.argmin(length)) + 2}")
    t[1:-1] /= length[:, None]
    if len(x) == 2:
        t[:] = edge[0]
        return t
    t[0] = 2.0 * (edge[0] @ t[1]) * edge[0] - t[1]
    t[-1] = 2.0 * (edge[-1] @ t[-2]) * edge[-1] - t[-2]
    return t


def rotation_minimising_frame(points: ArrayLike, start: ArrayLike | None = None) -> Array:
    """Frames without twist along a polyline, by double reflection.

    Source: Wang, Juettler, Zheng and Liu, ACM Trans. Graph. 27, 2 (2008); fourth order in the spacing.

    Args:
        points: shape (n, 3).
        start: direction of d1 at the first node, projected onto its section, shape (3,). Given, the frames turn with
            the points under a rigid motion. None takes the coordinate axis most across the first tangent (e_x for a rod
            along e_z).

    Returns:
        Shape (n, 3, 3), rows d1, d2, t at each node, right-handed.

    Raises:
        InputError: points that `tangents` refuses, or a start along the tangent.
    """
    x = as_points(points)
    t = tangents(x)
    seed = unit(start) if start is not None else np.eye(3)[int(np.argmin(np.abs(t[0]).round(9)))]
    across = seed - (seed @ t[0]) * t[0]
    if np.linalg.norm(across) < 1e-9:
        raise InputError("the frame's first direction lies along the rod", found=seed.tolist())
    return _double_reflection(x, t, unit(across))


@kernel
def _carry(d: Array, chord: Array, t: Array, t_next: Array) -> Array:
    """Double reflection of d: first across the chord, then so that the tangents match."""
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
            d = _carry(d, x[i] - x[i - 1], t[i - 1], t[i])
        frames[i, 0] = d
        frames[i, 1] = np.cross(t[i], d)
        frames[i, 2] = t[i]
    return frames


def turn_frames(frames: ArrayLike, angles: ArrayLike) -> Array:
    """Turn each frame about its own tangent.

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
    """Twist from each frame to the next: the angle of d1 left over after carrying it along without twist.

    Args:
        frames: rows d1, d2, t, shape (n, 3, 3).
        points: of the nodes, shape (n, 3). Given, d1 is carried by double reflection, so that a rotation-minimising
            frame has no twist at all; None carries it by the smallest rotation that aligns the tangents.

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
        d = _carry(f[i, 0], chord[i], f[i, 2], f[i + 1, 2])
        twist[i] = math.atan2(-np.dot(d, f[i + 1, 1]), np.dot(d, f[i + 1, 0]))
    return twist


def writhe(points: ArrayLike) -> float:
    """Writhe of an open polyline: Gauss's double integral, exact for straight edges.

    Each pair of edges adds the signed solid angle of the parallelogram of directions from one edge to the other.

    Args:
        points: shape (n, 3). Repeat the first point at the end for a closed polygon.

    Returns:
        Positive for a right-handed helix.
    """
    return float(_writhe(as_points(points)))


@kernel
def _writhe(x: Array) -> float:
    total = 0.0
    for i in range(len(x) - 1):
        for j in range(i + 2, len(x) - 1):
            total += _triangle(x, i, j, i, j + 1, i + 1, j + 1) + _triangle(x, i, j, i + 1, j + 1, i + 1, j)
    return total / (2.0 * math.pi)


@kernel
def _triangle(x: Array, a0: int, a1: int, b0: int, b1: int, c0: int, c1: int) -> float:
    """Signed solid angle of the triangle of directions x[.1] - x[.0] (Van Oosterom and Strackee 1983)."""
    ax, ay, az = x[a1, 0] - x[a0, 0], x[a1, 1] - x[a0, 1], x[a1, 2] - x[a0, 2]
    bx, by, bz = x[b1, 0] - x[b0, 0], x[b1, 1] - x[b0, 1], x[b1, 2] - x[b0, 2]
    cx, cy, cz = x[c1, 0] - x[c0, 0], x[c1, 1] - x[c0, 1], x[c1, 2] - x[c0, 2]
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    base = (
        a * b * c
        + (ax * bx + ay * by + az * bz) * c
        + (bx * cx + by * cy + bz * cz) * a
        + (cx * ax + cy * ay + cz * az) * b
    )
    return -2.0 * math.atan2(volume, base)
