"""Smooth approximation of the largest stretch deviation, with its gradient; the symbols are those of `extremes`."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.types import Array


@kernel
def smoothed_deviation(
    start: Array, end: Array, temporary: Array, times: Array, sharpness: float
) -> tuple[float, float, Array, Array]:
    """Smooth approximation of max |lambda - 1| over edges and sampled times, from above, with its gradient.

    It is log(sum of exp(b (lambda - 1)) + exp(-b (lambda - 1)))/b with the sharpness b. Terms below exp(-40) times the
    largest are left out.

    Args:
        start: E, shape (3,).
        end: e_1, shape (n, 3).
        temporary: w, shape (n, 3).
        times: sampled mapping times, shape (k,).
        sharpness: b. With N edges and k times, the value exceeds the maximum by at most log(2 N k)/b.

    Returns:
        The smooth value, the sampled maximum, and the derivatives with respect to start, shape (3,), and temporary,
        shape (n, 3).
    """
    n, k = len(end), len(times)
    stretches = np.empty((n, k))
    largest = 0.0
    for i in range(n):
        for j in range(k):
            t = times[j]
            square = 0.0
            for a in range(3):
                square += ((1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * temporary[i, a]) ** 2
            stretches[i, j] = np.sqrt(square)
            largest = max(largest, abs(stretches[i, j] - 1.0))
    by_start = np.zeros(3)
    by_temporary = np.zeros((n, 3))
    total = 0.0
    cutoff = 40.0 / sharpness
    for i in range(n):
        for j in range(k):
            excess = stretches[i, j] - 1.0
            if abs(excess) < largest - cutoff:
                continue
            above = np.exp(sharpness * (excess - largest))
            below = np.exp(sharpness * (-excess - largest))
            total += above + below
            t = times[j]
            pull = (above - below) / max(stretches[i, j], 1e-12)
            for a in range(3):
                part = pull * ((1.0 - t) * start[a] + t * end[i, a] + t * (1.0 - t) * temporary[i, a])
                by_start[a] += (1.0 - t) * part
                by_temporary[i, a] += t * (1.0 - t) * part
    return largest + np.log(total) / sharpness, largest, by_start / total, by_temporary / total
