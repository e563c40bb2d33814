"""Laplacian smoothing of a discretised centreline."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import Array, as_points


def laplacian(points: ArrayLike, gamma: float = 0.1, iterations: int = 1000) -> Array:
    """Smooth by x_i <- x_i - gamma [x_i - (x_(i-1) + x_(i+1)) / 2], all nodes at once, both ends fixed.

    Source: Aymon et al., Extreme Mech. Lett. 81, 102413 (2025), appendix, uniform Laplacian smoothing.

    Args:
        points: shape (n, 3).
        gamma: strength of one pass, 0 <= gamma <= 1 (beyond 1 the shortest wave grows).
        iterations: number of passes; 0 changes nothing.

    Returns:
        Shape (n, 3), a new array.

    Raises:
        InputError: gamma or iterations outside their range, or points that `as_points` refuses.
    """
    if not 0.0 <= gamma <= 1.0:
        raise InputError("smoothing strength gamma is out of range", found=gamma, expected="0 to 1")
    if iterations < 0:
        raise InputError("smoothing iterations are negative", found=iterations, expected="0 or more")
    x = as_points(points).copy()
    half = 0.5 * gamma
    for _ in range(iterations):
        x[1:-1] += half * (x[2:] - 2.0 * x[1:-1] + x[:-2])
    return x


def gaussian_width(gamma: float, iterations: int, spacing: float) -> float:
    """Standard deviation of the Gaussian that the smoothing amounts to: spacing sqrt(gamma iterations).

    Args:
        gamma: strength of one pass.
        iterations: number of passes.
        spacing: distance of neighbouring vertices, mm.

    Returns:
        mm.
    """
    return spacing * math.sqrt(gamma * iterations)
