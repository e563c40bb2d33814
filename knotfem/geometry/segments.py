"""Distance between two straight segments, for compiled loops over the edges of polylines."""

from __future__ import annotations

import math

from knotfem.compiled import kernel
from knotfem.types import Array


@kernel
def segment_distance(a: Array, b: Array, c: Array, d: Array) -> float:
    """Smallest distance between the segments a-b and c-d; end points of shape (3,).

    Where the line through a-b comes closest to the line through c-d, its parameter is clipped to the segment; then the
    closest point of c-d to this point is found, and the closest point of a-b to that one, each clipped likewise. A
    segment may have length zero.
    Source: Ericson, Real-Time Collision Detection (2005), section 5.1.9.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = d[0] - c[0], d[1] - c[1], d[2] - c[2]
    wx, wy, wz = a[0] - c[0], a[1] - c[1], a[2] - c[2]
    uu = ux * ux + uy * uy + uz * uz
    vv = vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    uw = ux * wx + uy * wy + uz * wz
    vw = vx * wx + vy * wy + vz * wz
    s = 0.0
    if uu > 0.0:
        determinant = uu * vv - uv * uv
        if vv > 0.0 and determinant > 1e-14 * uu * vv:
            s = min(1.0, max(0.0, (uv * vw - vv * uw) / determinant))
        t = (uv * s + vw) / vv if vv > 0.0 else 0.0
        t = min(1.0, max(0.0, t))
        s = min(1.0, max(0.0, (uv * t - uw) / uu))
    else:
        t = min(1.0, max(0.0, vw / vv)) if vv > 0.0 else 0.0
    x, y, z = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return math.sqrt(x * x + y * y + z * z)


@kernel
def boxes_apart(low_i: Array, high_i: Array, low_j: Array, high_j: Array, distance: float) -> bool:
    """Whether two axis-aligned boxes are farther apart than a distance along at least one axis.

    Args:
        low_i: smallest coordinates of the first box, shape (3,).
        high_i: its largest coordinates, shape (3,).
        low_j: smallest coordinates of the second box, shape (3,).
        high_j: its largest coordinates, shape (3,).
        distance: that separates them.
    """
    gap = 0.0
    for k in range(3):
        gap = max(gap, low_i[k] - high_j[k], low_j[k] - high_i[k])
    return gap > distance
