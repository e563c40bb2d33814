"""Clearances: smallest distances between strands, between rods, and from a rod to a cylinder."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from knotfem.compiled import kernel
from knotfem.geometry.measures import arclength, turning_angles
from knotfem.geometry.points import as_points
from knotfem.geometry.segments import segment_distance
from knotfem.geometry.vectors import from_axis
from knotfem.types import Array

NEIGHBOUR_RADII = 3.2
"""Arclength, in rod radii, below which two cross-sections belong to one strand.

It is a little more than pi, the half circle of radius r along which the tightest possible hairpin bend runs."""


class Clearance(NamedTuple):
    """Smallest distance between two strands.

    Attributes:
        distance: between the centrelines, mm; infinite if there is no pair of strands.
        i: edge of the first strand, from point i to i + 1; -1 if there is no pair.
        j: edge of the second strand, likewise.
    """

    distance: float
    i: int
    j: int


def strand_clearance(points: ArrayLike, diameter: float) -> Clearance:
    """Smallest distance between two strands of one rod.

    Two edges count as parts of one strand, and are left out, if the arclength between them is less than 3.2 radii or if
    the tangent turns by less than pi between them. No contact is missed: a chord at which the distance between two
    points of the curve has a local minimum is perpendicular to the curve at both ends, so that the closed curve of arc
    and chord has at most pi of its total curvature in its two corners; by Fenchel's theorem the total is at least
    2 pi, and the arc turns by at least pi. How close a single bend comes to itself is limited by its curvature.

    Args:
        points: of the centreline, shape (n, 3), mm.
        diameter: of the rod, mm.

    Raises:
        InputError: points that `as_points` refuses; the same holds for the other functions of this module.
    """
    x = as_points(points)
    turning = np.concatenate([[0.0], np.cumsum(turning_angles(x))])
    distance, i, j = _closest_strands(x, arclength(x), turning, NEIGHBOUR_RADII * 0.5 * diameter)
    return Clearance(float(distance), int(i), int(j))


@kernel
def _closest_strands(x: Array, s: Array, turning: Array, neighbour: float) -> tuple[float, int, int]:
    best, best_i, best_j = math.inf, -1, -1
    for i in range(len(x) - 1):
        for j in range(i + 2, len(x) - 1):
            if s[j] - s[i + 1] < neighbour or turning[j] - turning[i] < math.pi:
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
    """Smallest distance between the centrelines of two rods, with the edge of each where it occurs.

    Args:
        first: points of one centreline, shape (n, 3), mm.
        second: points of the other, shape (m, 3), mm.
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
    """Gap between the surfaces of a rod and a cylinder of infinite length; negative if they overlap.

    Args:
        points: of the rod's centreline, shape (n, 3), mm.
        point: any point of the cylinder's axis, shape (3,), mm.
        axis: its direction, shape (3,), of any length.
        cylinder_diameter: mm.
        diameter: of the rod, mm.

    Returns:
        mm.
    """
    across = from_axis(as_points(points), point, axis)
    edge = np.diff(across, axis=0)
    square = (edge * edge).sum(axis=1)
    foot = np.clip(-(across[:-1] * edge).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    nearest = np.linalg.norm(across[:-1] + foot[:, None] * edge, axis=1).min()
    return float(nearest) - 0.5 * (cylinder_diameter + diameter)


def close_strands(points: ArrayLike, diameter: float, reach: float = 2.5) -> NDArray[np.bool_]:
    """Mark the points of a centreline that have another strand nearby: the knot without its tails.

    Args:
        points: shape (n, 3), mm.
        diameter: of the rod, mm.
        reach: distance between two points that counts as near, in diameters. They belong to two strands if the
            arclength between them is more than pi times this distance.

    Returns:
        True for points of the knot, shape (n,).
    """
    x = as_points(points)
    arc = arclength(x)
    pairs = KDTree(x).query_pairs(reach * diameter, output_type="ndarray")
    pairs = pairs[np.abs(arc[pairs[:, 0]] - arc[pairs[:, 1]]) > np.pi * reach * diameter]
    near = np.zeros(len(x), dtype=bool)
    near[pairs.ravel()] = True
    return near
