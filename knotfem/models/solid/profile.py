"""Rows of tension.csv, from hexahedra."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from knotfem.models.solid.body import Body
from knotfem.models.solid.resultants import resultants


def profile_rows(body: Body, x: np.ndarray, time: float, displacement: float) -> Iterator[dict[str, float | str]]:
    """Rows of tension.csv for one state: a row a section of every rod.

    Args:
        body: rods, with the pressures and core forces of the state.
        x: positions [mm], shape [nodes, 3].
        time: [s].
        displacement: of the reported end [mm].
    """
    for rod in body.rods:
        r = resultants(x, rod.section_nodes, rod.mesh.section.axis, rod.bulk, rod.core)
        arclength = np.arange(rod.mesh.slices + 1) * rod.mesh.element_length
        centre = x[rod.axis_nodes]
        columns = zip(arclength, r.tension, r.core, r.bulk, r.shear, r.bending_moment, r.torque, centre, strict=True)
        for s, tension, core, bulk, shear, bending, torque, place in columns:
            yield {
                "displacement_mm": displacement,
                "arclength_mm": float(s),
                "s_over_L": float(s / arclength[-1]),
                "tension_N": float(tension),
                "core_N": float(core),
                "bulk_N": float(bulk),
                "rod": rod.scene.name,
                "time_s": time,
                "shear_N": float(shear),
                "bending_moment_Nmm": float(bending),
                "torque_Nmm": float(torque),
                "x_mm": float(place[0]),
                "y_mm": float(place[1]),
                "z_mm": float(place[2]),
            }
