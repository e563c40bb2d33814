"""Discrete rods and their contact, in plain numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.finite_rotation import parallel_transport
from knotfem.geometry.vectors import perpendicular, unit_edges


@dataclass(frozen=True, eq=False)
class RodSpec:
    """One rod.

    Attributes:
        points: nodes [mm], shape [n + 1, 3].
        radius: [mm].
        bending: B [N mm^2].
        twisting: C [N mm^2].
        axial: EA [N].
        mass_per_length: [tonne/mm].
        spacing: length of a segment free of stress [mm], or that of each, shape [n]; None for the mean chord.
        directors: material director of each segment, across it, shape [n, 3]; None for a rod free of twist.
        relaxation_time: of internal damping [s].
    """

    points: np.ndarray
    radius: float
    bending: float
    twisting: float
    axial: float
    mass_per_length: float
    spacing: float | np.ndarray | None = None
    directors: np.ndarray | None = None
    relaxation_time: float = 0.0


@dataclass(frozen=True, eq=False)
class ContactSpec:
    """Contact between all strands.

    Attributes:
        stiffness: line stiffness [N/mm^2]; `hertz_line_stiffness` gives rubber's.
        friction: mu of each pair of rods, shape [rods, rods], or one number.
        ramp: overlap over which the force rises smoothly [mm].
        stick: tangential displacement at which friction is fully mobilised [mm].
        sample_spacing: largest distance between samples [mm].
        onset_over_ramp: gap at which contact begins, over the ramp.
    """

    stiffness: float
    friction: np.ndarray | float
    ramp: float
    stick: float
    sample_spacing: float
    onset_over_ramp: float = 0.5


def directors_of(rod: RodSpec) -> np.ndarray:
    """Directors of the segments, as given or free of twist, and a last row that means nothing, shape [n + 1, 3]."""
    n = len(rod.points) - 1
    if rod.directors is not None:
        if rod.directors.shape != (n, 3):
            raise InputError(
                "one director for each segment", key="rods", found=rod.directors.shape, expected=f"({n}, 3)"
            )
        return np.concatenate([rod.directors, np.zeros((1, 3))])
    t = unit_edges(rod.points)
    return np.concatenate([parallel_transport(t, perpendicular(t[0])), np.zeros((1, 3))])
