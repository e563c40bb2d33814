"""Rods, contact and obstacles of the reduced model, in plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError

MINDLIN_STIFFNESS_RATIO = 2.0 / 3.0
"""Tangential over normal stiffness of a Hertz contact, 2 (1 - nu)/(2 - nu), for nu = 1/2 (Mindlin 1949)."""


@dataclass(frozen=True, eq=False)
class RodSpec:
    """One rod.

    Attributes:
        points: nodes [mm], near equal chords, shape [n + 1, 3].
        radius: [mm].
        bending: B [N mm^2].
        twisting: C [N mm^2].
        axial: EA [N].
        mass_per_length: [tonne/mm].
        spacing: length of a segment free of stress [mm]; None for the mean chord.
        directors: material director of each segment, across it, shape [n, 3]; None for a rod free of twist.
        relaxation_time: of internal damping [s].
    """

    points: np.ndarray
    radius: float
    bending: float
    twisting: float
    axial: float
    mass_per_length: float
    spacing: float | None = None
    directors: np.ndarray | None = None
    relaxation_time: float = 0.0


@dataclass(frozen=True, eq=False)
class ContactSpec:
    """Contact between all strands.

    Attributes:
        stiffness: line stiffness [N/mm^2]; `hertz_line_stiffness` gives rubber's.
        friction: mu of each pair of rods, shape [rods, rods], or one number.
        ramp: overlap over which the force rises smoothly [mm].
        sample_spacing: largest distance between samples [mm].
        tangential: stiffness of the friction springs in units of the normal one.
        factor: multiplies all coefficients, as a function of time [s].
    """

    stiffness: float
    friction: np.ndarray | float
    ramp: float
    sample_spacing: float
    tangential: float = MINDLIN_STIFFNESS_RATIO
    factor: Callable[[float], float] | None = None


@dataclass(frozen=True, eq=False)
class CylinderSpec:
    """A rigid cylinder.

    Attributes:
        origin: a point of its axis [mm], shape [3].
        axis: of any length, shape [3].
        radius: [mm].
        friction: mu of each rod, shape [rods], or one number.
        stiffness: line stiffness [N/mm^2]; None for twice the rods'.
    """

    origin: np.ndarray
    axis: np.ndarray
    radius: float
    friction: np.ndarray | float
    stiffness: float | None = None


def twist_free_directors(rod: RodSpec) -> np.ndarray:
    """Directors of the segments, as given or free of twist, and a last row that means nothing, shape [n + 1, 3]."""
    n = len(rod.points) - 1
    if rod.directors is not None:
        if rod.directors.shape != (n, 3):
            raise InputError("one director a segment", key="rod model", found=rod.directors.shape, expected=f"({n}, 3)")
        return np.concatenate([rod.directors, np.zeros((1, 3))])
    edge = np.diff(rod.points, axis=0)
    t = edge / np.linalg.norm(edge, axis=1)[:, None]
    d = np.zeros((n + 1, 3))
    d[0] = np.eye(3)[int(np.argmin(np.abs(t[0]).round(9)))]
    d[0] -= (d[0] @ t[0]) * t[0]
    d[0] /= np.linalg.norm(d[0])
    for j in range(1, n):
        d[j] = d[j - 1] - (d[j - 1] @ t[j]) / (1.0 + t[j - 1] @ t[j]) * (t[j - 1] + t[j])
    return d
