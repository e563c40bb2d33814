"""Closing an open rod far away, so that its knot type is defined, and counting its turns round an axis."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import Array, as_points, unit

EndDirection = Literal["tangent", "outward"] | ArrayLike
"""Where an end goes on: along its outward tangent, away from the middle of the rod, or along a vector of shape (3,)."""

FAR = 10.0
"""Radius of the sphere on which the ends are joined, over the radius of the rod's own bounding ball."""


def close(
    points: ArrayLike,
    ends: tuple[EndDirection, EndDirection] = ("tangent", "tangent"),
    sphere: tuple[Array, float] | None = None,
) -> Array:
    """Close an open polyline: each end goes straight on to a far sphere, and the two are joined along a great circle.

    The joining arc lies outside everything else, so the knot depends on the two directions only. Where an open end lies
    inside a loop (the tail of a bowline), different directions give different knots.

    Args:
        points: shape (n, 3), first = loading end.
        ends: directions of the first and the last end.
        sphere: centre, shape (3,), and radius of the far sphere; None for one round the rod's own middle.

    Returns:
        Closed polygon without repetition of its first point, shape (n + m, 3).

    Raises:
        InputError: points that `as_points` refuses, or a direction that is none.
    """
    x = as_points(points)
    if sphere is None:
        middle = 0.5 * (x.min(axis=0) + x.max(axis=0))
        sphere = middle, FAR * float(np.linalg.norm(x - middle, axis=1).max())
    centre, radius = sphere
    first = _far_end(x[0], x[0] - x[1], ends[0], centre, radius)
    last = _far_end(x[-1], x[-1] - x[-2], ends[1], centre, radius)
    return np.vstack([x, _great_circle(last - centre, first - centre) + centre])


def _far_end(end: Array, tangent: Array, wanted: EndDirection, centre: Array, radius: float) -> Array:
    if isinstance(wanted, str):
        if wanted not in ("tangent", "outward"):
            raise InputError("unknown direction of an end", found=wanted, expected="tangent, outward or a vector")
        direction = unit(tangent) if wanted == "tangent" else unit(end - centre)
    else:
        direction = unit(wanted)
    from_centre = end - centre
    along = float(from_centre @ direction)
    return end + (-along + math.sqrt(along * along - float(from_centre @ from_centre) + radius * radius)) * direction


def _great_circle(start: Array, stop: Array) -> Array:
    """Points on the shorter great circle from start to stop, both included, at most 45 degrees apart."""
    radius = float(np.linalg.norm(start))
    a, b = start / radius, stop / radius
    across = b - (b @ a) * a
    length = float(np.linalg.norm(across))
    angle = math.atan2(length, float(a @ b))
    if length < 1e-12:
        across = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        length = float(np.linalg.norm(across))
    pieces = max(1, math.ceil(angle / (0.25 * math.pi)))
    steps = np.linspace(0.0, angle, pieces + 1)[:, None]
    arc = np.asarray(np.cos(steps) * a + np.sin(steps) * across / length, dtype=np.float64) * radius
    return arc if angle > 1e-9 else arc[:1]


def winding_angle(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> float:
    """Angle by which a polyline turns about an axis, right-handed.

    Args:
        points: shape (n, 3).
        point: any point of the axis, shape (3,).
        axis: its direction, shape (3,).

    Returns:
        rad; 2 pi for one full turn.
    """
    along = unit(axis)
    across = as_points(points) - np.asarray(point, dtype=np.float64)
    across = across - np.outer(across @ along, along)
    sine = np.cross(across[:-1], across[1:]) @ along
    return float(np.arctan2(sine, (across[:-1] * across[1:]).sum(axis=1)).sum())


def linking_number(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> int:
    """Linking number of a rod with an endless straight axis: whole turns about it.

    Both ends are taken straight away from the axis, far out, and joined there by the shorter way round it, which adds
    what is missing to the nearest whole number of turns. Looking along the axis, clockwise counts positive.

    Args:
        points: shape (n, 3).
        point: any point of the axis, shape (3,).
        axis: its direction, shape (3,).
    """
    return round(winding_angle(points, point, axis) / (2.0 * math.pi))
