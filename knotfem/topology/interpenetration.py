"""Whether a strand has passed through another between two states of a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.compiled import kernel
from knotfem.errors import InputError
from knotfem.geometry.measures import NEIGHBOUR_RADII, arclength
from knotfem.geometry.points import Array, as_points
from knotfem.geometry.segments import boxes_apart, segment_distance

MEETING = 0.05
"""Two centrelines closer than this, in diameters, have met: strands in contact keep theirs about one diameter apart."""


class Passage(NamedTuple):
    """A meeting of two centrelines on the way from one state to the next.

    Attributes:
        rods: number of either rod.
        edges: of either rod, from its node i to i + 1.
        time: between 0 (before) and 1 (after).
    """

    rods: tuple[int, int]
    edges: tuple[int, int]
    time: float


def passed_through(
    before: ArrayLike | Sequence[ArrayLike], after: ArrayLike | Sequence[ArrayLike], diameter: float
) -> Passage | None:
    """Find the first passage of one strand through another while every node moves straight from one state to the next.

    Two strands that are at least c apart in both states cannot be reported wrongly as long as one moves relative to the
    other by less than 2 sqrt(c^2 - (diameter / 20)^2), because their distance on a straight way falls to
    sqrt(c^2 - motion^2 / 4) at most: with contact (c about one diameter), each may move by almost a diameter a step.
    Pairs of one rod closer along the arc than 3.2 radii are neighbours and left out.

    Args:
        before: nodes of the rod, shape (n, 3), or a list of such for several rods, mm.
        after: the same nodes afterwards.
        diameter: of the rods (the smallest), mm.

    Returns:
        None when all is well.

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
    neighbour, meeting = 0.5 * NEIGHBOUR_RADII * diameter, MEETING * diameter
    time, i, j = _first_meeting(np.concatenate(first), np.concatenate(second), edges, rod, arc, neighbour, meeting)
    if i < 0:
        return None
    rods = int(rod[i]), int(rod[j])
    return Passage(rods, (int(edges[i] - node[rods[0]]), int(edges[j] - node[rods[1]])), float(time))


def _rods(state: ArrayLike | Sequence[ArrayLike]) -> list[Array]:
    several = isinstance(state, list | tuple) and len(state) > 0 and np.ndim(state[0]) == 2
    return [as_points(x) for x in state] if several else [as_points(state)]  # type: ignore[union-attr]


@kernel
def _first_meeting(
    x: Array,
    y: Array,
    edges: NDArray[np.int64],
    rod: NDArray[np.int64],
    arc: Array,
    neighbour: float,
    meeting: float,
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
            if boxes_apart(low[i], high[i], low[j], high[j], meeting):
                continue
            time = _meeting_time(x, y, edges[i], edges[j], meeting)
            if time < first:
                first, first_i, first_j = time, i, j
    return first, first_i, first_j


@kernel
def _meeting_time(x: Array, y: Array, i: int, j: int, meeting: float) -> float:
    """Time at which two moving edges come within a distance; 2 if they do not.

    Advances by distance over the largest relative speed, which can neither overshoot nor, stopping at `meeting`, stall.
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
        if distance < meeting:
            return time
        if speed == 0.0:
            return 2.0
        time += distance / speed
    return 2.0
