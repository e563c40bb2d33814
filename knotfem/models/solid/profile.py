"""Rows of tension.csv, from hexahedra."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from knotfem.geometry.slices import Slices
from knotfem.models.base import Row
from knotfem.models.profile import SectionForces, tension_rows
from knotfem.models.solid.body import Body
from knotfem.models.solid.resultants import resultants


def profile_rows(body: Body, x: np.ndarray, time: float, displacement: float) -> Iterator[Row]:
    """Rows of tension.csv for one state: a row for each section of every rod.

    Args:
        body: rods, with the pressures and core forces of the state.
        x: positions [mm], shape [nodes, 3].
        time: [s].
        displacement: of the reported end [mm].
    """
    for rod in body.rods:
        r = resultants(x, rod.section_nodes, rod.mesh.section.axis, rod.bulk, rod.core)
        forces = SectionForces(
            Slices(rod.mesh.lengths),
            x[rod.axis_nodes],
            r.tension,
            r.core,
            r.bulk,
            r.shear,
            r.bending_moment,
            r.torque,
        )
        yield from tension_rows(rod.scene.name, forces, time, displacement)
