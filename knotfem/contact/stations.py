"""Stations: the cross-sections of hexahedral rods, the nodes of discrete ones, and arclength between them.

A point of a rod has the coordinate u in segments. Its arclength when free of stress is the basis applied to the
arclengths of the stations: where it lies along the straight rod, however the lengths of the slices change.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.basis import axial_basis
from knotfem.geometry.slices import Slices


class Stations(NamedTuple):
    """Stations of all rods.

    Attributes:
        node: axis node of each station, rods one behind the other, shape [stations].
        first: first station of each rod, and the number of all, shape [rods + 1].
        arclength: of each when free of stress [mm], shape [stations].
        longest: distance of neighbours when free of stress [mm], shape [rods].
        radius: of each rod [mm], shape [rods].
    """

    node: np.ndarray
    first: np.ndarray
    arclength: np.ndarray
    longest: np.ndarray
    radius: np.ndarray


def make_stations(node: np.ndarray, slices: Sequence[Slices], radius: Sequence[float] | np.ndarray) -> Stations:
    """Stations between the slices of rods.

    Args:
        node: axis node of each station, rods one behind the other, shape [stations].
        slices: of each rod.
        radius: of each rod [mm].
    """
    first = np.concatenate([[0], np.cumsum([rod.count + 1 for rod in slices])]).astype(np.int64)
    arclength = np.concatenate([rod.arclength for rod in slices])
    longest = np.array([rod.lengths.max() for rod in slices])
    return Stations(node, first, arclength, longest, np.array(radius, dtype=float))


@kernel
def arclength_at(stations: Stations, rod: int, u: float, w: np.ndarray) -> float:
    """Arclength of a point when free of stress [mm]; w (3, 3) is work space."""
    first = stations.first[rod]
    base = first + axial_basis(u, stations.first[rod + 1] - first, w)
    arc = stations.arclength
    return w[0, 0] * arc[base] + w[0, 1] * arc[base + 1] + w[0, 2] * arc[base + 2]


@kernel
def _arclengths(stations: Stations, rod: np.ndarray, u: np.ndarray, out: np.ndarray) -> None:
    w = np.empty((3, 3))
    for k in range(u.size):
        out[k] = arclength_at(stations, rod[k], u[k], w)


def arclengths(stations: Stations, rod: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Arclengths of points when free of stress [mm], shape [n].

    Args:
        stations: of all rods.
        rod: of each point, shape [n].
        u: coordinate in segments, shape [n].
    """
    found = np.empty(u.size)
    _arclengths(stations, rod, np.ascontiguousarray(u), found)
    return found
