"""Simplification of closed polygons by triangle moves, which keep the knot type."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from knotfem.compiled import kernel
from knotfem.types import Array

PERTURBATION = 1e-7
"""Largest random displacement of the vertices relative to the extent of the polygons, which brings them into general
position: no four of them lie in a plane."""


def simplify(polygons: Sequence[Array]) -> list[Array]:
    """Remove every vertex whose triangle with its two neighbours is not pierced by another edge, until none is left.

    The vertices are first displaced at random, always in the same way, by up to 1e-7 of the extent, which is far less
    than any distance between strands.
    Source: Koniaris and Muthukumar, Phys. Rev. Lett. 66, 2211 (1991); Taylor, Nature 406, 916 (2000).

    Args:
        polygons: closed, the first point not repeated, each of shape (n, 3); together a link.

    Returns:
        Closed polygons of the same link, each of at least 3 vertices.
    """
    sizes = [len(polygon) for polygon in polygons]
    first = np.concatenate([[0], np.cumsum(sizes)])
    x = np.concatenate(polygons)
    extent = float(np.ptp(x, axis=0).max())
    x = x + PERTURBATION * extent * np.random.default_rng(20250).uniform(-1.0, 1.0, x.shape)
    after = np.arange(1, len(x) + 1)
    after[first[1:] - 1] = first[:-1]
    before = np.empty_like(after)
    before[after] = np.arange(len(x))
    component = np.repeat(np.arange(len(sizes)), sizes)
    alive = _triangle_moves(x, before, after, component, np.array(sizes))
    return [x[a:b][alive[a:b]] for a, b in pairwise(first)]


@kernel
def _triangle_moves(
    x: Array, before: NDArray[np.int64], after: NDArray[np.int64], component: NDArray[np.int64], left: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which vertices are left; `left` counts them for each component."""
    alive = np.ones(len(x), dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        for i in range(len(x)):
            if not alive[i] or left[component[i]] <= 3:
                continue
            a, c = before[i], after[i]
            if _pierced(x, alive, after, a, i, c):
                continue
            after[a] = c
            before[c] = a
            alive[i] = False
            left[component[i]] -= 1
            changed = True
    return alive


@kernel
def _pierced(x: Array, alive: NDArray[np.bool_], after: NDArray[np.int64], a: int, b: int, c: int) -> bool:
    """Whether the triangle of the vertices a, b, c is pierced by an edge that has no end in common with it."""
    for p in range(len(x)):
        q = after[p]
        if not alive[p] or p in (a, b, c) or q in (a, b, c):
            continue
        apart = False
        for k in range(3):
            low = min(x[a, k], x[b, k], x[c, k])
            high = max(x[a, k], x[b, k], x[c, k])
            if max(x[p, k], x[q, k]) < low or min(x[p, k], x[q, k]) > high:
                apart = True
        if apart or _volume(x, a, b, c, p) * _volume(x, a, b, c, q) > 0.0:
            continue
        v1, v2, v3 = _volume(x, p, q, a, b), _volume(x, p, q, b, c), _volume(x, p, q, c, a)
        if (v1 >= 0.0 and v2 >= 0.0 and v3 >= 0.0) or (v1 <= 0.0 and v2 <= 0.0 and v3 <= 0.0):
            return True
    return False


@kernel
def _volume(x: Array, a: int, b: int, c: int, d: int) -> float:
    """Six times the signed volume of a tetrahedron; 0 if it is below the rounding error and its sign unknown."""
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    wx, wy, wz = x[d, 0] - x[a, 0], x[d, 1] - x[a, 1], x[d, 2] - x[a, 2]
    p, q, r = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    volume = p * wx + q * wy + r * wz
    size = (
        (abs(uy * vz) + abs(uz * vy)) * abs(wx)
        + (abs(uz * vx) + abs(ux * vz)) * abs(wy)
        + (abs(ux * vy) + abs(uy * vx)) * abs(wz)
    )
    return volume if abs(volume) > 1e-14 * size else 0.0
