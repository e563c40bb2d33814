"""Tension along the centreline: rows of tension.csv, and reading them back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.run.build import Body
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.section.resultants import resultants

EXTRA_COLUMNS = ("rod", "time_s", "shear_N", "bending_moment_Nmm", "torque_Nmm", "x_mm", "y_mm", "z_mm")


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
        columns = zip(
            arclength, r.tension, r.core, r.bulk, r.shear, r.bending_moment, r.torque, centre, strict=True
        )
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


def tension(run: RunDirectory, at: float | None = None) -> dict[str, np.ndarray]:
    """The tension profile at a stored displacement.

    Args:
        run: a run with a tension.csv.
        at: displacement [mm]; the nearest stored one is taken; None for the last.

    Returns:
        Columns of tension.csv, one state's rows.

    Raises:
        InputError: no profile is stored, or none near `at`.
    """
    path = Path(run.path) / "tension.csv"
    if not path.exists():
        raise InputError("no tension is stored yet", file=run.path, expected="a run that knotfem pull has brought on")
    table = read_table(path)
    if not table["displacement_mm"].size:
        raise InputError("no tension is stored yet", file=path, expected="at least one profile")
    times = np.unique(table["time_s"])
    displacements = np.array([table["displacement_mm"][table["time_s"] == time][0] for time in times])
    if at is None:
        chosen = times[-1]
    else:
        nearest = int(np.argmin(np.abs(displacements - at)))
        spacing = float(np.diff(displacements).max()) if len(displacements) > 1 else 0.0
        if abs(displacements[nearest] - at) > max(spacing, 1e-6 * max(1.0, math.fabs(at))):
            raise InputError(
                "no profile is stored near this displacement",
                key="--at",
                found=f"{at:g} mm",
                expected=f"{displacements.min():g} to {displacements.max():g} mm",
            )
        chosen = times[nearest]
    rows = table["time_s"] == chosen
    return {name: values[rows] for name, values in table.items()}
