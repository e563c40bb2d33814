"""Exact extremes in time of the edges' stretches: lambda^2(t) is a quartic for every edge."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.tie.path import Array


@kernel
def stationary_times(start: Array, end: Array, bump: Array) -> Array:
    """Times at which the edge (1 - t) start + t end + t (1 - t) bump may be longest or shortest.

    The slope of lambda^2 is a cubic. Its own turning points, the roots of a quadratic, cut [0, 1] into intervals
    where it is monotone; each change of sign is bisected to machine precision.

    Args:
        start: the straight rod's direction, shape (3,).
        end: target edges over h, shape (n, 3).
        bump: differences of the temporary displacement over h, shape (n, 3).

    Returns:
        Times in [0, 1], shape (n, 5): 0, 1 and up to three interior ones, filled up with 1.
    """
    n = len(end)
    times = np.ones((n, 5))
    times[:, 0] = 0.0
    cuts = np.empty(4)
    for i in range(n):
        ab = ac = bb = bc = cc = 0.0
        for k in range(3):
            a, b, c = start[k], end[i, k] - start[k] + bump[i, k], -bump[i, k]
            ab += a * b
            ac += a * c
            bb += b * b
            bc += b * c
            cc += c * c
        c0, c1, c2, c3 = ab, bb + 2.0 * ac, 3.0 * bc, 2.0 * cc
        cuts[0] = 0.0
        count = 1
        discriminant = c2 * c2 - 3.0 * c1 * c3
        if discriminant > 0.0:
            q = -(c2 + np.sqrt(discriminant)) if c2 > 0.0 else -(c2 - np.sqrt(discriminant))
            first = q / (3.0 * c3) if c3 > 0.0 else 2.0
            second = c1 / q if q != 0.0 else 2.0
            for root in (min(first, second), max(first, second)):
                if 0.0 < root < 1.0:
                    cuts[count] = root
                    count += 1
        cuts[count] = 1.0
        found = 2
        for j in range(count):
            low, high = cuts[j], cuts[j + 1]
            slope_low = c0 + low * (c1 + low * (c2 + low * c3))
            slope_high = c0 + high * (c1 + high * (c2 + high * c3))
            if slope_low * slope_high >= 0.0:
                continue
            for _ in range(60):
                middle = 0.5 * (low + high)
                slope = c0 + middle * (c1 + middle * (c2 + middle * c3))
                if slope * slope_low > 0.0:
                    low = middle
                else:
                    high = middle
            times[i, found] = 0.5 * (low + high)
            found += 1
    return times


@kernel
def edges_at(start: Array, end: Array, bump: Array, times: Array) -> Array:
    """Returns the edges over h at times (n, k) of their own, shape (n, k, 3)."""
    n, k = times.shape
    edges = np.empty((n, k, 3))
    for i in range(n):
        for j in range(k):
            t = times[i, j]
            for a in range(3):
                edges[i, j, a] = (1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * bump[i, a]
    return edges


def extreme_stretches(start: Array, end: Array, bump: Array) -> tuple[Array, Array]:
    """Returns stationary times and the stretches there, both of shape (n, 5); arguments as in `stationary_times`."""
    times = stationary_times(start, end, bump)
    return times, np.linalg.norm(edges_at(start, end, bump, times), axis=2)


def deviation(start: Array, end: Array, bump: Array) -> float:
    """Returns max |lambda - 1| over all edges and all times in [0, 1]; arguments as in `stationary_times`."""
    return float(np.abs(extreme_stretches(start, end, bump)[1] - 1.0).max())


def stretch_range(start: Array, end: Array, bump: Array) -> dict[str, float]:
    """Returns smallest and largest stretch and max |lambda - 1| by name; arguments as in `stationary_times`."""
    stretches = extreme_stretches(start, end, bump)[1]
    return {
        "min_stretch": float(stretches.min()),
        "max_stretch": float(stretches.max()),
        "max_stretch_deviation": float(np.abs(stretches - 1.0).max()),
    }
