"""Broad phase: which samples of the centrelines may touch which rod, and where."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.curve import project
from knotfem.contact.tube_search import NEIGHBOUR_ARC_OVER_RADIUS
from knotfem.geometry.rotation import dot


@kernel
def _longest_edges(x, first):
    """Longest edge of each rod."""
    longest = np.zeros(first.size - 1)
    for rod in range(longest.size):
        for j in range(first[rod], first[rod + 1] - 1):
            square = 0.0
            for i in range(3):
                square += (x[j + 1, i] - x[j, i]) ** 2
            longest[rod] = max(longest[rod], np.sqrt(square))
    return longest


@kernel
def _minima(x, point, first, count, longest, own, excluded, reach, found):
    """Nodes of a rod at a local minimum of distance to a point, within reach; `own` +- excluded nodes are left out.

    From a node far away the search goes on where the rod, of edges no longer than `longest`, can be within reach again.
    """
    n = j = 0
    previous = current = np.inf
    while j <= count:
        following, ahead = np.inf, 1
        if j < count and abs(j - own) > excluded:
            following = 0.0
            for i in range(3):
                following += (point[i] - x[first + j, i]) ** 2
            if following > reach * reach:
                ahead = max(1, int((np.sqrt(following) - reach) / longest))
        if current < reach * reach and current <= previous and current < following and n < found.size:
            found[n] = j - 1
            n += 1
        previous, current = current, following
        j += ahead
    return n


@kernel
def find_pairs(x, first, spacing, radius, sample_u, sample_start, points, cutoff, out, out_u):
    """All pairs of a sample and a closest point on a rod with a gap below `cutoff` [mm], ordered by sample.

    `points` are the samples' places, (samples, 3); `out` (capacity, 2) gets sample and rod of each pair, `out_u`
    (capacity) the coordinate of its closest point; for the rest see `RodLayout` and `Samples`.

    Returns:
        Number of pairs; larger than the capacity where that was too small.
    """
    w, C, q = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    found = np.empty(64, np.int64)
    longest = _longest_edges(x, first)
    total = 0
    for slave in range(radius.size):
        s = sample_start[slave]
        for i in range(first[slave + 1] - first[slave]):
            begin = s
            while s < sample_start[slave + 1] and sample_u[s] < i + 0.5:
                s += 1
            for master in range(radius.size):
                own, excluded = -1.0, -1.0
                if master == slave:
                    own, excluded = float(i), NEIGHBOUR_ARC_OVER_RADIUS * radius[slave] / spacing[slave]
                limit = radius[slave] + radius[master] + cutoff
                reach = limit + spacing[slave] + spacing[master]
                count = first[master + 1] - first[master]
                point = x[first[slave] + i]
                near = _minima(x, point, first[master], count, longest[master], own, excluded, reach, found)
                for p in range(begin, s):
                    opened = total
                    for m in range(near):
                        u, _, inside = project(x, first[master], count, points[p], float(found[m]), w, C, q)
                        if not inside or dot(q, q) > limit * limit:
                            continue
                        if master == slave and abs(u - sample_u[p]) <= excluded:
                            continue
                        twin = False
                        for k in range(opened, min(total, out.shape[0])):
                            twin = twin or abs(out_u[k] - u) < 1e-6
                        if twin:
                            continue
                        if total < out.shape[0]:
                            out[total, 0], out[total, 1] = p, master
                            out_u[total] = u
                        total += 1
    return total


@kernel
def match_pairs(old, old_u, new, new_u, reach):
    """For each new pair the old one of the same sample and rod within `reach` segments (shape [rods]), or -1.

    Both are ordered by sample; each old pair goes to at most one new one, the nearest first come.
    """
    match = np.full(new.shape[0], -1, np.int64)
    taken = np.zeros(old.shape[0], np.bool_)
    o = 0
    for k in range(new.shape[0]):
        s, rod = new[k]
        while o < old.shape[0] and old[o, 0] < s:
            o += 1
        best, p = reach[rod], o
        while p < old.shape[0] and old[p, 0] == s:
            distance = abs(old_u[p] - new_u[k])
            if old[p, 1] == rod and distance < best and not taken[p]:
                best = distance
                match[k] = p
            p += 1
        if match[k] >= 0:
            taken[match[k]] = True
    return match
