"""Tension along the centreline, read back from tension.csv."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table

EXTRA_COLUMNS = ("rod", "time_s", "shear_N", "bending_moment_Nmm", "torque_Nmm", "x_mm", "y_mm", "z_mm")
NEEDED = ("time_s", "displacement_mm", "s_over_L", "tension_N")
"""Columns without which tension.csv says nothing."""


@dataclass(frozen=True, eq=False)
class StoredStates:
    """States whose profiles are stored.

    Attributes:
        path: the table they are in.
        table: its columns.
        times: [s], ascending.
        displacements: of the reported end at those times [mm].
    """

    path: Path
    table: dict[str, np.ndarray]
    times: np.ndarray
    displacements: np.ndarray

    def nearest(self, at: float | None) -> tuple[float, float]:
        """Time and displacement of the state nearest to a displacement, or of the last.

        Raises:
            InputError: it is less than the smallest or more than the largest.
        """
        if at is None:
            return float(self.times[-1]), float(self.displacements[-1])
        i = int(np.argmin(np.abs(self.displacements - at)))
        slack = 1e-6 * max(1.0, abs(at))
        if not self.displacements.min() - slack <= at <= self.displacements.max() + slack:
            raise InputError(
                "no state is stored near this displacement",
                file=self.path,
                key="--at",
                found=f"{at:g} mm",
                expected=f"{self.displacements.min():g} to {self.displacements.max():g} mm",
            )
        return float(self.times[i]), float(self.displacements[i])


def stored_states(run: RunDirectory) -> StoredStates:
    """The states of a run whose profiles are stored.

    Raises:
        InputError: there are none.
    """
    path = run.path / "tension.csv"
    table = read_table(path, NEEDED) if path.exists() else {}
    if not table or not table["time_s"].size:
        raise InputError("no tension is stored yet", file=run.path, expected="a run that knotfem pull has brought on")
    times, first = np.unique(table["time_s"], return_index=True)
    return StoredStates(path, table, times, table["displacement_mm"][first])


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
    states = stored_states(run)
    time, _ = states.nearest(at)
    rows = states.table["time_s"] == time
    return {name: values[rows] for name, values in states.table.items()}
