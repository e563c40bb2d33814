"""Interpenetration of strands between two states of a simulation, which would change the knot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.compiled import kernel
from knotfem.errors import InputError
from knotfem.geometry.clearance import NEIGHBOUR_RADII
from knotfem.geometry.measures import arclength
from knotfem.geometry.points import as_points
from knotfem.geometry.segments import boxes_apart, segment_distance
from knotfem.types import Array

CROSSING = 0.05
"""Distance between two centrelines, in diameters, below which they count as crossing each other. For strands in contact
it is about one diameter."""


class Interpenetration(NamedTuple):
    """A crossing of two centrelines on the way from one state to the next.

    Attributes:
        rods: indices of the two rods, which may be the same.
        edges: of each of them, from node i to i + 1.
        time: at which it happens, from 0 (before) to 1 (after).
    """

    rods: tuple[int, int]
    edges: tuple[int, int]
    time: float


def first_interpenetration(
    before: ArrayLike | Sequence[ArrayLike], after: ArrayLike | Sequence[ArrayLike], diameter: float
) -> Interpenetration | None:
    """Find the first crossing of two centrelines while every node moves on a straight line from one state to the next.

    A pair of strands whose distance is at least c in both states is not reported falsely if one moves relative to the
    other by less than 2 sqrt(c^2 - (diameter/20)^2), because the distance of two points that move on straight lines
    does not fall below sqrt(c^2 - motion^2/4). With contact, c is about one diameter, and each strand may move by
    almost a diameter per step. Pairs of edges of one rod with less than 3.2 radii of arclength between them are left
    out.

    Args:
        before: nodes of a rod, shape (n, 3), or a list of such arrays for several rods, mm.
        after: the same nodes in the later state.
        diameter: of the thinnest rod, mm.

    Returns:
        None if no strand passes through another.

    Raises:
        InputError: the states do not have the same rods and nodes, or are not finite.
    """
    first, second = _rods(before), _rods(after)
    if [len(x) for x in first] != [len(x) for x in second]:
        sizes = [len(x) for x in first], [len(x) for x in second]
        raise InputError("the two states differ in their nodes", found=sizes[1], expected=str(sizes[0]))
    node = np.concatenate([[0], np.cumsum([len(x) for x in first])])
    edges = np.concatenate([np.arange(a, b - 1) for a, b in pairwise(node)])
    rod = np.repeat(np.arange(len(first)), [len(x) - 1 for x in first])
    arc = np.concatenate([arclength(x) for x in first])
    neighbour, crossing = 0.5 * NEIGHBOUR_RADII * diameter, CROSSING * diameter
    time, i, j = _first_crossing(np.concatenate(first), np.concatenate(second), edges, rod, arc, neighbour, crossing)
    if i < 0:
        return None
    rods = int(rod[i]), int(rod[j])
    return Interpenetration(rods, (int(edges[i] - node[rods[0]]), int(edges[j] - node[rods[1]])), float(time))


def _rods(state: ArrayLike | Sequence[ArrayLike]) -> list[Array]:
    several = isinstance(state, list | tuple) and len(state) > 0 and np.ndim(state[0]) == 2
    return [as_points(x) for x in state] if several else [as_points(state)]  # type: ignore[union-attr]


@kernel
def _first_crossing(
    x: Array,
    y: Array,
    edges: NDArray[np.int64],
    rod: NDArray[np.int64],
    arc: Array,
    neighbour: float,
    crossing: float,
) -> tuple[float, int, int]:
    low, high = np.empty((len(edges), 3)), np.empty((len(edges), 3))
    for i in range(len(edges)):
        e = edges[i]
        for k in range(3):
            low[i, k] = min(x[e, k], x[e + 1, k], y[e, k], y[e + 1, k])
            high[i, k] = max(x[e, k], x[e + 1, k], y[e, k], y[e + 1, k])
    first, first_i, first_j = 2.0, -1, -1
    for i in range(len(edges)):
        for j in range(i + 1, len(edges)):
            if rod[i] == rod[j] and arc[edges[j]] - arc[edges[i] + 1] < neighbour:
                continue
            if boxes_apart(low[i], high[i], low[j], high[j], crossing):
                continue
            time = _crossing_time(x, y, edges[i], edges[j], crossing)
            if time < first:
                first, first_i, first_j = time, i, j
    return first, first_i, first_j


@kernel
def _crossing_time(x: Array, y: Array, i: int, j: int, crossing: float) -> float:
    """Time at which two moving edges come closer than a distance; 2 if they do not (conservative advancement).

    Each advance in time is the distance over the largest relative speed of the end points, so that none goes past a
    contact; as each is at least crossing/speed, the number of advances is bounded.
    """
    speed = 0.0
    for a in (i, i + 1):
        for b in (j, j + 1):
            v = (y[a] - x[a]) - (y[b] - x[b])
            speed = max(speed, np.sqrt(np.dot(v, v)))
    time = 0.0
    while time <= 1.0:
        distance = segment_distance(
            x[i] + time * (y[i] - x[i]),
            x[i + 1] + time * (y[i + 1] - x[i + 1]),
            x[j] + time * (y[j] - x[j]),
            x[j + 1] + time * (y[j + 1] - x[j + 1]),
        )
        if distance < crossing:
            return time
        if speed == 0.0:
            return 2.0
        time += distance / speed
    return 2.0
