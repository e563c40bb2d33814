"""Arclength, curvature and clearances of a polyline."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from knotfem.compiled import kernel
from knotfem.geometry.points import Array, as_points, unit
from knotfem.geometry.segments import segment_distance

NEIGHBOUR_RADII = 3.2
"""Arc, in rod radii, within which two sections are neighbours: just over the half circle of the tightest hairpin."""


class Clearance(NamedTuple):
    """Smallest distance between two strands.

    Attributes:
        distance: of the centrelines, mm; infinite when no two strands face each other.
        i: edge of the first strand (from point i to i + 1), -1 when there is none.
        j: edge of the second strand.
    """

    distance: float
    i: int
    j: int


def arclength(points: ArrayLike) -> Array:
    """Cumulative chord length from the first point, shape (n,)."""
    x = as_points(points)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])


def turning_angles(points: ArrayLike) -> Array:
    """Angle between the edges that meet at each inner point, rad, shape (n - 2,)."""
    edge = np.diff(as_points(points), axis=0)
    edge /= np.linalg.norm(edge, axis=1)[:, None]
    return 2.0 * np.arctan2(np.linalg.norm(edge[1:] - edge[:-1], axis=1), np.linalg.norm(edge[1:] + edge[:-1], axis=1))


def curvature(points: ArrayLike) -> Array:
    """Curvature at the nodes: 2 sin(angle / 2) over the mean of the two edges; the ends repeat their neighbours.

    Exact for equal chords of a circle.

    Args:
        points: shape (n, 3), mm.

    Returns:
        1/mm, shape (n,).
    """
    x = as_points(points)
    if len(x) == 2:
        return np.zeros(2)
    size = np.linalg.norm(np.diff(x, axis=0), axis=1)
    inner = 2.0 * np.sin(0.5 * turning_angles(x)) / (0.5 * (size[1:] + size[:-1]))
    return np.concatenate([inner[:1], inner, inner[-1:]])


def strand_clearance(points: ArrayLike, diameter: float) -> Clearance:
    """Smallest distance between strands of one rod.

    Left out are pairs that belong to one strand: those closer along the arc than 3.2 radii, and those between which the
    tangent turns by less than pi. By Fenchel's theorem no chord that is a local minimum of the distance has less
    turning between its ends (an arc closed by such a chord turns by 2 pi, at most pi of it in the two corners), so
    nothing that could touch is lost; how close a single bend comes to itself is a matter of its curvature.

    Args:
        points: shape (n, 3), mm.
        diameter: of the rod, mm.
    """
    x = as_points(points)
    turned = np.concatenate([[0.0], np.cumsum(turning_angles(x))])
    distance, i, j = _closest_strands(x, arclength(x), turned, NEIGHBOUR_RADII * 0.5 * diameter)
    return Clearance(float(distance), int(i), int(j))


@kernel
def _closest_strands(x: Array, s: Array, turned: Array, neighbour: float) -> tuple[float, int, int]:
    best, best_i, best_j = math.inf, -1, -1
    for i in range(len(x) - 1):
        for j in range(i + 2, len(x) - 1):
            if s[j] - s[i + 1] < neighbour or turned[j] - turned[i] < math.pi:
                continue
            reach = best + 0.5 * (s[i + 1] - s[i] + s[j + 1] - s[j])
            square = 0.0
            for k in range(3):
                square += (0.5 * (x[i, k] + x[i + 1, k] - x[j, k] - x[j + 1, k])) ** 2
            if square >= reach * reach:
                continue
            distance = segment_distance(x[i], x[i + 1], x[j], x[j + 1])
            if distance < best:
                best, best_i, best_j = distance, i, j
    return best, best_i, best_j


def rod_clearance(first: ArrayLike, second: ArrayLike) -> Clearance:
    """Smallest distance between the centrelines of two rods, with the edge of each.

    Args:
        first: shape (n, 3), mm.
        second: shape (m, 3), mm.
    """
    distance, i, j = _closest_edges(as_points(first), as_points(second))
    return Clearance(float(distance), int(i), int(j))


@kernel
def _closest_edges(x: Array, y: Array) -> tuple[float, int, int]:
    best, best_i, best_j = math.inf, -1, -1
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            distance = segment_distance(x[i], x[i + 1], y[j], y[j + 1])
            if distance < best:
                best, best_i, best_j = distance, i, j
    return best, best_i, best_j


def cylinder_clearance(
    points: ArrayLike, point: ArrayLike, axis: ArrayLike, cylinder_diameter: float, diameter: float
) -> float:
    """Gap between the surfaces of a rod and an endless cylinder; negative where they overlap.

    Args:
        points: of the rod's centreline, shape (n, 3), mm.
        point: any point of the cylinder's axis, shape (3,), mm.
        axis: its direction, shape (3,).
        cylinder_diameter: mm.
        diameter: of the rod, mm.

    Returns:
        mm.
    """
    along = unit(axis)
    across = as_points(points) - np.asarray(point, dtype=np.float64)
    across = across - np.outer(across @ along, along)
    edge = np.diff(across, axis=0)
    square = (edge * edge).sum(axis=1)
    foot = np.clip(-(across[:-1] * edge).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    nearest = np.linalg.norm(across[:-1] + foot[:, None] * edge, axis=1).min()
    return float(nearest) - 0.5 * (cylinder_diameter + diameter)
