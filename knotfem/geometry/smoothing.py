"""Laplacian smoothing of a discretised centreline."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import as_points
from knotfem.types import Array

PASS_BAND = 0.01
"""Of smoothing that keeps the size, as 1 - cos of the angle of a wave from point to point: longer waves, such as loops
of more than 44 points, are left as they are."""


def laplacian(points: ArrayLike, gamma: float = 0.1, iterations: int = 1000, *, keep_size: bool = False) -> Array:
    """Smooth a polyline by x_i <- x_i - gamma [x_i - (x_(i-1) + x_(i+1))/2], all points at once, both ends fixed.

    This shrinks loops: strands come closer. With `keep_size`, each such iteration is followed by one with the opposite
    sign and gamma/(1 - 0.01 gamma), which takes the shrinkage back and leaves the scatter removed.

    Source: Aymon et al., Extreme Mech. Lett. 81, 102413 (2025), Eq. (A.1); for `keep_size` Taubin, SIGGRAPH 95, 351.

    Args:
        points: shape (n, 3).
        gamma: strength of one iteration, 0 <= gamma <= 1; with more the shortest wave would grow.
        iterations: number of iterations; 0 changes nothing.
        keep_size: whether loops keep their size.

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
    weights = (gamma, -gamma / (1.0 - PASS_BAND * gamma)) if keep_size else (gamma,)
    for _ in range(iterations):
        for weight in weights:
            x[1:-1] += 0.5 * weight * (x[2:] - 2.0 * x[1:-1] + x[:-2])
    return x


def gaussian_width(gamma: float, iterations: int, spacing: float) -> float:
    """Standard deviation of the Gaussian filter along the arc that the smoothing amounts to: spacing sqrt(gamma N).

    Args:
        gamma: strength of one iteration.
        iterations: their number N.
        spacing: distance between neighbouring points, mm.

    Returns:
        mm.
    """
    return spacing * math.sqrt(gamma * iterations)
