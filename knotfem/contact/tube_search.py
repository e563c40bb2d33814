"""Broad phase: which samples may touch which rod, and where."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.tube import dot, project

NEIGHBOUR_ARC_OVER_RADIUS = 3.2
"""Strands of one rod closer along the arc than this many radii are not looked at."""

SWOLLEN = 1.25
"""Sections may swell by bending and squeezing up to this share of their radius."""

PAIRS_A_SAMPLE = 4
"""Room for closest points to begin with; strands in a bundle have more."""


def all_pairs(find: Callable[[np.ndarray, np.ndarray], int], samples: int, *parameters: int) -> tuple[np.ndarray, ...]:
    """Pairs and parameters of their closest points, in arrays that are made larger until they hold all.

    Args:
        find: fills pairs, shape [capacity, 2], and parameters, shape [capacity, *parameters], and says how many there
            are.
        samples: number of them.
        parameters: of a closest point where there is more than one.
    """
    capacity = PAIRS_A_SAMPLE * samples
    while True:
        pairs, at = np.empty((capacity, 2), dtype=np.int64), np.empty((capacity, *parameters))
        count = find(pairs, at)
        if count <= capacity:
            return pairs[:count].copy(), at[:count].copy()
        capacity = count


@kernel
def _start_angle(x, tubes, axis_node, rod, section, p):
    """Boundary node of a section that lies most in the direction of p."""
    ring, ring_start, around = tubes[0], tubes[1], tubes[2]
    k = around[rod]
    best, angle = -np.inf, 0
    for b in range(k):
        node = ring[ring_start[rod] + section * k + b]
        value = 0.0
        for i in range(3):
            value += (x[node, i] - x[axis_node, i]) * (p[i] - x[axis_node, i])
        if value > best:
            best, angle = value, b
    return angle


@kernel
def _distance(x, axis, start, count, j, p):
    """Distance of p from the edges of a centreline near section j, their lines going on for one edge."""
    nearest = np.inf
    for k in range(max(j - 3, 0), min(j + 3, count - 1)):
        a, b = axis[start + k], axis[start + k + 1]
        e0, e1, e2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        q0, q1, q2 = p[0] - x[a, 0], p[1] - x[a, 1], p[2] - x[a, 2]
        t = min(max((q0 * e0 + q1 * e1 + q2 * e2) / (e0 * e0 + e1 * e1 + e2 * e2), -1.0), 2.0)
        nearest = min(nearest, (q0 - t * e0) ** 2 + (q1 - t * e1) ** 2 + (q2 - t * e2) ** 2)
    return np.sqrt(nearest)


@kernel
def _minima(x, axis, axis_start, sections, spacing, radius, slave, i, master, reach, found):
    """Sections of the master rod at a local minimum of distance to section i of the slave, within reach."""
    count = sections[master]
    base = axis_start[master]
    a = x[axis[axis_start[slave] + i]]
    excluded = NEIGHBOUR_ARC_OVER_RADIUS * radius[slave] / spacing[slave] if slave == master else -1.0
    n = 0
    previous = np.inf
    current = np.inf
    for j in range(count + 1):
        following = np.inf
        if j < count and abs(j - i) > excluded:
            b = x[axis[base + j]]
            following = (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2
        if j > 0 and current < reach * reach and current <= previous and current < following and n < found.size:
            found[n] = j - 1
            n += 1
        previous, current = current, following
    return n


@kernel
def find_pairs(
    x, tubes, axis, axis_start, spacing, radius, sample_rod, sample_u, section_start, points, cutoff, out, out_uv
):
    """All pairs of a sample and a closest point with a gap below `cutoff` [mm].

    Args:
        x: positions, shape [nodes, 3].
        tubes: `Tubes.arrays`.
        axis, axis_start, spacing, radius: see `Tubes`.
        sample_rod, sample_u, section_start: see `Samples`.
        points: positions of the samples, shape [samples, 3].
        cutoff: largest gap.
        out: sample and rod of each pair, shape [capacity, 2].
        out_uv: parameters of the closest point, shape [capacity, 2].

    Returns:
        Number of pairs; larger than the capacity where that was too small.
    """
    sections = tubes[3]
    W, S = np.empty((6, 12)), np.empty((6, 3))
    nodes, q, n = np.empty(12, np.int64), np.empty(3), np.empty(3)
    found = np.empty(64, np.int64)
    total = 0
    row = 0
    for slave in range(sections.size):
        for i in range(sections[slave]):
            first, last = section_start[row], section_start[row + 1]
            row += 1
            for master in range(sections.size):
                reach = radius[slave] + radius[master] + cutoff + spacing[slave] + spacing[master]
                count = _minima(x, axis, axis_start, sections, spacing, radius, slave, i, master, reach, found)
                for m in range(count):
                    j = found[m]
                    node = axis[axis_start[master] + j]
                    wide = radius[master] + cutoff + spacing[slave] + spacing[master]
                    far = SWOLLEN * radius[master] + cutoff
                    for s in range(first, last):
                        p = points[s]
                        d2 = (p[0] - x[node, 0]) ** 2 + (p[1] - x[node, 1]) ** 2 + (p[2] - x[node, 2]) ** 2
                        if d2 > wide * wide:
                            continue
                        if _distance(x, axis, axis_start[master], sections[master], j, p) > far:
                            continue
                        start = _start_angle(x, tubes, node, master, j, p)
                        u, v, inside = project(x, tubes, master, p, float(j), float(start), W, nodes, S, q)
                        if not inside or abs(u - j) * spacing[master] > 2.0 * radius[master] + spacing[master]:
                            continue
                        if slave == master and abs(u - sample_u[s]) * spacing[slave] < (
                            NEIGHBOUR_ARC_OVER_RADIUS * radius[slave]
                        ):
                            continue
                        n[0] = S[2, 1] * S[1, 2] - S[2, 2] * S[1, 1]
                        n[1] = S[2, 2] * S[1, 0] - S[2, 0] * S[1, 2]
                        n[2] = S[2, 0] * S[1, 1] - S[2, 1] * S[1, 0]
                        gap = dot(q, n) / np.sqrt(dot(n, n))
                        if gap > cutoff or gap < -radius[master]:
                            continue
                        twin = False
                        for k in range(total - 1, -1, -1):
                            if k >= out.shape[0] or out[k, 0] < first:
                                break
                            if out[k, 0] == s and out[k, 1] == master and abs(out_uv[k, 0] - u) < 1e-6:
                                twin = True
                                break
                        if twin:
                            continue
                        if total < out.shape[0]:
                            out[total, 0], out[total, 1] = s, master
                            out_uv[total, 0], out_uv[total, 1] = u, v
                        total += 1
    return total


@kernel
def match_pairs(old, old_uv, new, new_uv, sample_count, reach, match):
    """For each new pair the old one of the same sample and rod within `reach` slices along it, or -1.

    Args:
        old, old_uv, new, new_uv: pairs sorted by sample.
        sample_count: number of samples.
        reach: in slices of each rod, shape [rods].
        match: result, shape [new pairs].
    """
    start = np.zeros(sample_count + 1, np.int64)
    for k in range(old.shape[0]):
        start[old[k, 0] + 1] += 1
    for s in range(sample_count):
        start[s + 1] += start[s]
    for k in range(new.shape[0]):
        s, rod = new[k, 0], new[k, 1]
        best = reach[rod]
        match[k] = -1
        for o in range(start[s], start[s + 1]):
            distance = abs(old_uv[o, 0] - new_uv[k, 0])
            if old[o, 1] == rod and distance < best:
                best = distance
                match[k] = o
