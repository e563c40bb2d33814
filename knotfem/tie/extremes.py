"""Exact extremes over the mapping time of the stretches of a polynomial mapping.

An edge at mapping time t, over the edge length h of the straight rod, is

    e(t) = (1 - t) E + t e_1 + t (1 - t) w,

with the direction E of the straight rod, the edge e_1 of the target over h and the difference w of the temporary
displacements of its two vertices over h. So lambda^2 = |e|^2 is a polynomial of degree four in t.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.types import Array


@kernel
def stationary_times(start: Array, end: Array, temporary: Array) -> Array:
    """Mapping times at which each edge may be longest or shortest.

    Args:
        start: E, shape (3,).
        end: e_1 of all edges, shape (n, 3).
        temporary: w of all edges, shape (n, 3).

    Returns:
        Times in [0, 1], shape (n, 5): 0, 1 and up to three inner ones; the rest is filled with 1.
    """
    n = len(end)
    times = np.ones((n, 5))
    times[:, 0] = 0.0
    cuts = np.empty(4)
    for i in range(n):
        ab = ac = bb = bc = cc = 0.0
        for k in range(3):
            a, b, c = start[k], end[i, k] - start[k] + temporary[i, k], -temporary[i, k]
            ab += a * b
            ac += a * c
            bb += b * b
            bc += b * c
            cc += c * c
        cubic = (ab, bb + 2.0 * ac, 3.0 * bc, 2.0 * cc)
        count = _monotone_intervals(cubic, cuts)
        found = 2
        for j in range(count):
            if _value(cubic, cuts[j]) * _value(cubic, cuts[j + 1]) < 0.0:
                times[i, found] = _bisect(cubic, cuts[j], cuts[j + 1])
                found += 1
    return times


@kernel
def _value(cubic: tuple[float, float, float, float], t: float) -> float:
    """c0 + c1 t + c2 t^2 + c3 t^3, half the derivative of lambda^2."""
    return cubic[0] + t * (cubic[1] + t * (cubic[2] + t * cubic[3]))


@kernel
def _monotone_intervals(cubic: tuple[float, float, float, float], cuts: Array) -> int:
    """Number of the intervals between 0 and 1 in which a cubic with c3 >= 0 is monotone; their bounds go into cuts."""
    _, c1, c2, c3 = cubic
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
    return count


@kernel
def _bisect(cubic: tuple[float, float, float, float], low: float, high: float) -> float:
    """Root of a cubic between two values of opposite sign, to machine precision."""
    value_low = _value(cubic, low)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _value(cubic, middle) * value_low > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def edges_at(start: Array, end: Array, temporary: Array, times: Array) -> Array:
    """Return e(t) of each edge at its own times.

    Args:
        start: E, shape (3,).
        end: e_1, shape (n, 3).
        temporary: w, shape (n, 3).
        times: k mapping times for each edge, shape (n, k).

    Returns:
        Shape (n, k, 3).
    """
    n, k = times.shape
    edges = np.empty((n, k, 3))
    for i in range(n):
        for j in range(k):
            t = times[i, j]
            for a in range(3):
                edges[i, j, a] = (1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * temporary[i, a]
    return edges


def extreme_stretches(start: Array, end: Array, temporary: Array) -> tuple[Array, Array]:
    """Return stationary times and the stretches there, both of shape (n, 5); arguments as in `stationary_times`."""
    times = stationary_times(start, end, temporary)
    return times, np.linalg.norm(edges_at(start, end, temporary, times), axis=2)


def deviation(start: Array, end: Array, temporary: Array) -> float:
    """Return max |lambda - 1| over all edges and all times in [0, 1]; arguments as in `stationary_times`."""
    return float(np.abs(extreme_stretches(start, end, temporary)[1] - 1.0).max())
