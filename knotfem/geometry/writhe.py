"""Writhe of a polyline."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from knotfem.compiled import kernel
from knotfem.geometry.points import as_points
from knotfem.types import Array


def writhe(points: ArrayLike) -> float:
    """Writhe of an open polyline: Gauss's double integral, exact for straight edges.

    Each pair of edges contributes the signed solid angle of the spherical quadrilateral that the directions from points
    of one edge to points of the other fill, over 2 pi.
    Source: Klenin and Langowski, Biopolymers 54, 307 (2000), who evaluate the same sum.

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
    """Minus the signed solid angle of the spherical triangle between the directions x[.1] - x[.0].

    Source: Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983).
    """
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
