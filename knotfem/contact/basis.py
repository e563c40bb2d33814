"""Uniform quadratic B-splines along and around a rod."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel


@kernel(inline="always")
def axial_basis(u: float, count: int, w: np.ndarray) -> int:
    """Basis, first and second derivatives along a rod into w (3, 3), with straight ghost points beyond its ends.

    Args:
        u: coordinate in segments.
        count: stations of the rod.
        w: filled.

    Returns:
        The first of the three stations.
    """
    i = int(np.floor(u + 0.5))
    i = min(max(i, 0), count - 1)
    t = u - i
    w[0, 0], w[0, 1], w[0, 2] = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    w[1, 0], w[1, 1], w[1, 2] = t - 0.5, -2.0 * t, t + 0.5
    w[2, 0], w[2, 1], w[2, 2] = 1.0, -2.0, 1.0
    if i == 0:
        for d in range(3):
            ghost, at, after = w[d, 0], w[d, 1], w[d, 2]
            w[d, 0], w[d, 1], w[d, 2] = at + 2.0 * ghost, after - ghost, 0.0
        return 0
    if i == count - 1:
        for d in range(3):
            before, at, ghost = w[d, 0], w[d, 1], w[d, 2]
            w[d, 0], w[d, 1], w[d, 2] = 0.0, before - ghost, at + 2.0 * ghost
        return count - 3
    return i - 1


@kernel(inline="always")
def ring_basis(v: float, around: int, w: np.ndarray) -> int:
    """Basis, first and second derivatives around a rod into w (3, 3); returns the middle one of the three nodes."""
    j = int(np.floor(v + 0.5))
    t = v - j
    w[0, 0], w[0, 1], w[0, 2] = 0.5 * (0.5 - t) ** 2, 0.75 - t * t, 0.5 * (0.5 + t) ** 2
    w[1, 0], w[1, 1], w[1, 2] = t - 0.5, -2.0 * t, t + 0.5
    w[2, 0], w[2, 1], w[2, 2] = 1.0, -2.0, 1.0
    return j % around


@kernel(inline="always")
def middle_station(u: float, count: int) -> int:
    """Middle one of the three stations around a coordinate."""
    return min(max(int(np.floor(u + 0.5)), 1), count - 2)
