"""Rows of tension.csv: internal forces along a rod, whatever it is modelled by."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from knotfem.geometry.measures import vertex_means
from knotfem.geometry.slices import Slices
from knotfem.geometry.vectors import unit_edges, unit_vectors
from knotfem.models.base import Row


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Internal forces of one rod at its cross-sections, shape [sections] each.

    Attributes:
        slices: between them.
        places: of the centreline [mm], shape [sections, 3].
        tension: [N].
        core, bulk: axial force of either [N].
        shear: [N].
        bending_moment, torque: [N mm].
    """

    slices: Slices
    places: np.ndarray
    tension: np.ndarray
    core: np.ndarray
    bulk: np.ndarray
    shear: np.ndarray
    bending_moment: np.ndarray
    torque: np.ndarray


def tension_rows(rod: str, forces: SectionForces, time: float, displacement: float) -> Iterator[Row]:
    """Rows of one rod, one for each cross-section.

    Args:
        rod: its name.
        forces: at its cross-sections.
        time: [s].
        displacement: of the reported end [mm].
    """
    arclength, fractions = forces.slices.arclength, forces.slices.fractions
    for i, (x, y, z) in enumerate(forces.places):
        yield {
            "displacement_mm": displacement,
            "arclength_mm": float(arclength[i]),
            "s_over_L": float(fractions[i]),
            "tension_N": float(forces.tension[i]),
            "core_N": float(forces.core[i]),
            "bulk_N": float(forces.bulk[i]),
            "rod": rod,
            "time_s": time,
            "shear_N": float(forces.shear[i]),
            "bending_moment_Nmm": float(forces.bending_moment[i]),
            "torque_Nmm": float(forces.torque[i]),
            "x_mm": float(x),
            "y_mm": float(y),
            "z_mm": float(z),
        }


def section_tangents(places: np.ndarray) -> np.ndarray:
    """Unit tangents at cross-sections with these centres: the means of the edges' directions, shape [sections, 3]."""
    return unit_vectors(vertex_means(unit_edges(places)))
