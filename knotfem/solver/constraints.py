"""Constraints: nodes whose places are given, and ends of discrete rods whose orientation is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Orientation = Callable[[float], tuple[np.ndarray, np.ndarray]]
"""Unit tangent (along the arclength) and material director of an end as functions of time [s], shape [3] each."""


@dataclass(frozen=True, eq=False)
class Prescribed:
    """Nodes whose positions are given as a function of time.

    Args:
        nodes: shape [n].
        positions: time [s] to positions [mm], shape [n, 3].
        label: the end it belongs to, such as "rod.start".
        components: which of x, y, z are prescribed; the others stay free.
    """

    nodes: np.ndarray
    positions: Callable[[float], np.ndarray]
    label: str = ""
    components: tuple[bool, bool, bool] = (True, True, True)


@dataclass(frozen=True, eq=False)
class Clamp:
    """An end of a discrete rod whose orientation is given.

    Args:
        node: first or last node of a rod.
        orientation: tangent and director.
    """

    node: int
    orientation: Orientation


def held(nodes: np.ndarray, positions: np.ndarray, label: str = "") -> Prescribed:
    """Nodes that stay where they are."""
    fixed = positions.copy()
    return Prescribed(nodes, lambda time: fixed, label)


def driven(
    nodes: np.ndarray, positions: np.ndarray, direction: np.ndarray, path: Callable[[float], float], label: str = ""
) -> Prescribed:
    """Nodes carried without rotation along `direction` by path(time) [mm]."""
    fixed = positions.copy()
    return Prescribed(nodes, lambda time: fixed + path(time) * direction, label)
