"""Motions that are given: nodes held, driven or turned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


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


def turned(
    nodes: np.ndarray,
    positions: np.ndarray,
    centre: np.ndarray,
    axis: np.ndarray,
    angle: Callable[[float], float],
    label: str = "",
) -> Prescribed:
    """Nodes turned rigidly about an axis through `centre` by angle(time) [rad]."""
    arm = positions - centre
    axis = axis / np.linalg.norm(axis)

    def place(time: float) -> np.ndarray:
        a = angle(time)
        along = np.outer(arm @ axis, axis)
        return centre + along + np.cos(a) * (arm - along) + np.sin(a) * np.cross(axis, arm)

    return Prescribed(nodes, place, label)
