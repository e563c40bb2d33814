"""Linking of an open rod with a straight axis, and of two open rods with each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.points import as_points
from knotfem.geometry.vectors import from_axis, unit
from knotfem.topology.closure import FAR, close
from knotfem.topology.jones import Laurent, jones
from knotfem.topology.knot_type import simplest_diagram
from knotfem.types import Array

Ends = tuple[ArrayLike, ArrayLike]
"""Directions in which the first and the last end of a rod are continued, each of shape (3,)."""


def winding_angle(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> float:
    """Angle by which a polyline turns about an axis, right-handed.

    Args:
        points: shape (n, 3).
        point: any point of the axis, shape (3,).
        axis: its direction, shape (3,), of any length.

    Returns:
        rad; 2 pi for one full turn.

    Raises:
        InputError: points that `as_points` refuses, or an axis of length zero.
    """
    return float(_turns_of_edges(points, point, axis).sum())


def winding_range(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> float:
    """Largest angle by which a part of a polyline turns about an axis, in either direction.

    Where a rod winds back as far as it wound, as in a cow hitch, the angle of the whole is zero, this one is not.

    Args:
        points: shape (n, 3).
        point: any point of the axis, shape (3,).
        axis: its direction, shape (3,), of any length.

    Returns:
        rad; 2 pi for one full turn.

    Raises:
        InputError: points that `as_points` refuses, or an axis of length zero.
    """
    return float(np.ptp(np.concatenate([[0.0], np.cumsum(_turns_of_edges(points, point, axis))])))


def _turns_of_edges(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> Array:
    """Angle by which each edge turns about an axis, right-handed [rad], shape (n - 1,)."""
    across = from_axis(as_points(points), point, axis)
    sine = np.cross(across[:-1], across[1:]) @ unit(axis)
    return np.asarray(np.arctan2(sine, (across[:-1] * across[1:]).sum(axis=1)), dtype=np.float64)


def linking_number(points: ArrayLike, point: ArrayLike, axis: ArrayLike) -> int:
    """Linking number of an open rod with an infinite straight axis.

    The rod is closed by radial lines from its ends away from the axis and by an arc far away that joins them by less
    than half a turn. The linking number of this closed curve is the winding angle over 2 pi, rounded to an integer.

    Args:
        points: shape (n, 3).
        point: any point of the axis, shape (3,).
        axis: its direction, shape (3,), of any length.

    Returns:
        Positive for right-handed turns, which are clockwise for an observer who looks along the axis.

    Raises:
        InputError: points that `as_points` refuses, or an axis of length zero.
    """
    return round(winding_angle(points, point, axis) / (2.0 * math.pi))


@dataclass(frozen=True)
class LinkType:
    """How two open rods are linked.

    Attributes:
        jones: Jones polynomial of the link of the two closed rods.
        linked: whether the rods are linked, as far as the Jones polynomial shows.
    """

    jones: Laurent
    linked: bool


def link_type(rods: tuple[ArrayLike, ArrayLike], ends: tuple[Ends, Ends]) -> LinkType:
    """Decide whether two open rods are linked.

    Each rod is closed far away as in `closure.close`, on spheres of different radii. The reference is the link of two
    straight rods between the same ends, closed by the same arcs, into each of which the knot of its rod is tied; its
    Jones polynomial is the product of that of the straight link and those of the two knots. The rods are linked if the
    two links have different Jones polynomials. Interlocked bights, a sheet bend and a reef knot of two ropes are
    linked, rods that only touch or cross are not. The closing arcs may be linked themselves; being the same in both
    links, they have no influence.

    Args:
        rods: points, shape (n, 3) and (m, 3).
        ends: how the ends of either rod are continued. Keep them fixed when several states are compared.

    Raises:
        InputError: points that `as_points` refuses, or a zero direction.
    """
    first, second = as_points(rods[0]), as_points(rods[1])
    both = np.concatenate([first, second])
    centre = 0.5 * (both.min(axis=0) + both.max(axis=0))
    radius = FAR * float(np.linalg.norm(both - centre, axis=1).max())

    def closed(x: Array, which: int) -> Array:
        return close(x, ends[which], (centre, (1.0 + 0.1 * which) * radius))

    own = jones(simplest_diagram([closed(first, 0)])) * jones(simplest_diagram([closed(second, 1)]))
    link = jones(simplest_diagram([closed(first, 0), closed(second, 1)]))
    straight = jones(simplest_diagram([closed(first[[0, -1]], 0), closed(second[[0, -1]], 1)]))
    return LinkType(link, link != own * straight)
