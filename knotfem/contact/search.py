"""Search for pairs: which samples may touch which rod, and where; and which pairs were there before.

Stations (cross-sections or nodes) of a rod at a local minimum of distance to a station of a rod are candidates; each
sample nearest to the one is then projected near the other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.samples import SampleView
from knotfem.contact.stations import Stations, arclengths
from knotfem.contact.surface import Surface

TWINS = 1e-6
"""Closest points nearer to each other than this, in segments, are one."""


def grown(fill: Callable[[int], tuple[int, tuple[np.ndarray, ...]]], capacity: int) -> tuple[np.ndarray, ...]:
    """Arrays of a length that is not known beforehand.

    Args:
        fill: fills arrays of a capacity and says how long they need to be.
        capacity: to begin with.
    """
    while True:
        count, arrays = fill(capacity)
        if count <= capacity:
            return tuple(array[:count].copy() for array in arrays)
        capacity = count


@kernel
def _longest_edges(x: np.ndarray, stations: Stations) -> np.ndarray:
    """Longest edge between neighbouring stations of each rod."""
    longest = np.zeros(stations.first.size - 1)
    for rod in range(longest.size):
        for j in range(stations.first[rod], stations.first[rod + 1] - 1):
            a, b = stations.node[j], stations.node[j + 1]
            square = (x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2 + (x[b, 2] - x[a, 2]) ** 2
            longest[rod] = max(longest[rod], np.sqrt(square))
    return longest


@kernel
def _find_candidates(x: np.ndarray, stations: Stations, cutoff: float, neighbour: float, out: np.ndarray) -> int:
    """Station, rod and station of that rod of all candidates into out, shape [capacity, 3].

    From a station far away the search goes on where the rod, of edges no longer than its longest, can be within reach
    again.

    Returns:
        Number of candidates; larger than the capacity where that was too small.
    """
    longest = _longest_edges(x, stations)
    rods, total = longest.size, 0
    for own in range(rods):
        for i in range(stations.first[own], stations.first[own + 1]):
            a = stations.node[i]
            for rod in range(rods):
                reach = stations.radius[own] + stations.radius[rod] + cutoff
                reach += stations.longest[own] + stations.longest[rod]
                excluded = neighbour * stations.radius[own] if rod == own else -1.0
                start, here = stations.first[rod], stations.arclength[i]
                count = stations.first[rod + 1] - stations.first[rod]
                j, behind = 0, 0
                previous = current = np.inf
                while j <= count:
                    following, ahead = np.inf, 1
                    if j < count and abs(stations.arclength[start + j] - here) > excluded:
                        b = stations.node[start + j]
                        following = (x[a, 0] - x[b, 0]) ** 2 + (x[a, 1] - x[b, 1]) ** 2 + (x[a, 2] - x[b, 2]) ** 2
                        if following > reach * reach:
                            ahead = max(1, int((np.sqrt(following) - reach) / longest[rod]))
                    if current < reach * reach and current <= previous and current < following:
                        if total < out.shape[0]:
                            out[total, 0], out[total, 1], out[total, 2] = i, rod, behind
                        total += 1
                    previous, current, behind = current, following, j
                    j += ahead
    return total


def _sought(candidates: np.ndarray, sample_start: np.ndarray) -> np.ndarray:
    """Sample, rod, and station of the rod, of each sample of each candidate, shape [n, 3]."""
    station, rod, near = candidates.T
    first, counts = sample_start[station], sample_start[station + 1] - sample_start[station]
    candidate = np.repeat(np.arange(len(candidates)), counts)
    within = np.arange(len(candidate)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([first[candidate] + within, rod[candidate], near[candidate]], axis=1)


@kernel
def match_pairs(
    old: np.ndarray, old_s: np.ndarray, new: np.ndarray, new_s: np.ndarray, reach: np.ndarray, match: np.ndarray
) -> None:
    """For each new pair the old one of the same sample and rod within reach along it, or -1, into match.

    Both are ordered by sample; each old pair goes to at most one new one, the nearest first come.

    Args:
        old: sample and rod of each pair, shape [pairs, 2].
        old_s: arclength of the closest point [mm], shape [pairs].
        new: sample and rod of each new pair, shape [new pairs, 2].
        new_s: likewise, shape [new pairs].
        reach: of each rod [mm], shape [rods].
        match: shape [new pairs].
    """
    match[:] = -1
    taken = np.zeros(old.shape[0], np.bool_)
    o = 0
    for k in range(new.shape[0]):
        s, rod = new[k]
        while o < old.shape[0] and old[o, 0] < s:
            o += 1
        best, p = reach[rod], o
        while p < old.shape[0] and old[p, 0] == s:
            distance = abs(old_s[p] - new_s[k])
            if old[p, 1] == rod and distance < best and not taken[p]:
                best = distance
                match[k] = p
            p += 1
        if match[k] >= 0:
            taken[match[k]] = True


def find_pairs(
    x: np.ndarray, surface: Surface, samples: SampleView, sample_start: np.ndarray, points: np.ndarray, cutoff: float
) -> tuple[np.ndarray, np.ndarray]:
    """All pairs with a gap below `cutoff` [mm], ordered by sample, rod and coordinate along it.

    Args:
        x: positions, shape [nodes, width].
        surface: of all rods.
        samples: of all rods.
        sample_start: first sample of each station, shape [stations + 1].
        points: places of the samples, shape [samples, 3].
        cutoff: largest gap.

    Returns:
        Sample and rod of each pair, shape [pairs, 2], and parameters of its closest point, shape [pairs, parameters].
    """
    stations, neighbour = surface.stations, surface.limits.neighbour

    def candidates(capacity: int) -> tuple[int, tuple[np.ndarray, ...]]:
        out = np.empty((capacity, 3), dtype=np.int64)
        return _find_candidates(x, stations, cutoff, neighbour, out), (out,)

    (near,) = grown(candidates, 4 * stations.node.size)

    sought = _sought(near, sample_start)
    gap, at = surface.seek(x, samples, points, sought, cutoff)
    sample, rod = sought[:, 0], sought[:, 1]
    own = samples.rod[sample]
    arc = np.abs(arclengths(stations, rod, at[:, 0]) - arclengths(stations, own, samples.at[sample, 0]))
    neighbours = (own == rod) & (arc < neighbour * stations.radius[rod])
    kept = np.flatnonzero((gap <= cutoff) & ~neighbours)
    order = kept[np.lexsort((at[kept, 0], rod[kept], sample[kept]))]
    pairs, at = sought[order, :2], at[order]
    twins = (pairs[1:] == pairs[:-1]).all(axis=1) & (np.diff(at[:, 0]) < TWINS)
    single = np.concatenate([[True], ~twins]) if len(pairs) else np.zeros(0, dtype=bool)
    return pairs[single], at[single]
