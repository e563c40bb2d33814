"""Closure of an open curve by an arc far away, which makes its knot type well defined.

Only a closed curve has a knot type in the strict sense; that of an open curve depends on how its ends are continued.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import as_points
from knotfem.geometry.vectors import perpendicular, unit
from knotfem.types import Array

EndDirection = Literal["tangent", "outward"] | ArrayLike
"""How an end is continued: straight along its outward tangent, straight away from the centre of the far sphere, or
along a vector of shape (3,)."""

FAR = 10.0
"""Radius of the sphere on which the ends are joined, relative to the radius of a ball that contains the curve."""


def close(
    points: ArrayLike,
    ends: tuple[EndDirection, EndDirection] = ("tangent", "tangent"),
    sphere: tuple[Array, float] | None = None,
) -> Array:
    """Close an open polyline: continue both ends straight to a far sphere and join them there along a great circle.

    The joining arc lies outside the curve, so the knot depends on the directions of the two ends only. If an end lies
    inside a loop, as the tail of a bowline does, different directions may give different knots.

    Args:
        points: shape (n, 3), beginning with the loading end.
        ends: how the first and the last end are continued.
        sphere: centre, shape (3,), and radius of the far sphere; None takes one about the middle of the bounding box.

    Returns:
        Closed polygon, its first point not repeated, shape (n + m, 3).

    Raises:
        InputError: points that `as_points` refuses, or an unknown or zero direction.
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
    """Points on the shorter great-circle arc from start to stop, both included, at most 45 degrees apart."""
    radius = float(np.linalg.norm(start))
    a, b = start / radius, stop / radius
    across = b - (b @ a) * a
    length = float(np.linalg.norm(across))
    angle = math.atan2(length, float(a @ b))
    if length < 1e-12:
        across, length = np.cross(a, perpendicular(a)), 1.0
    pieces = max(1, math.ceil(angle / (0.25 * math.pi)))
    steps = np.linspace(0.0, angle, pieces + 1)[:, None]
    arc = np.asarray(np.cos(steps) * a + np.sin(steps) * across / length, dtype=np.float64) * radius
    return arc if angle > 1e-9 else arc[:1]
