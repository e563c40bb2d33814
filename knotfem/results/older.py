"""Tables of older versions, whose displacement starts again at each step of the scene."""

from __future__ import annotations

import numpy as np

from knotfem.run.columns import RUNNING
from knotfem.types import Arrays


def running_forces(table: Arrays) -> Arrays:
    """The columns of force.csv, in which the displacement runs on through the steps.

    Args:
        table: as it is read; one of this version, or without steps, is given back as it is.
    """
    if RUNNING in table or "displacement_mm" not in table or "step" not in table:
        return table
    within, steps, before = table["displacement_mm"], table["step"], 0.0
    there = within.copy()
    for name in dict.fromkeys(steps.tolist()):
        rows = steps == name
        there[rows] += before
        before = max(before, float(there[rows][-1]))
    return {**table, "displacement_mm": there, RUNNING: within}


def running(table: Arrays, force: Arrays) -> Arrays:
    """The columns of a table of stored states, in which the displacement runs on through the steps.

    Args:
        table: as it is read; one of this version, or without displacements, is given back as it is.
        force: columns of force.csv, in which it runs on; other states, and those of its first time, are of steps
            before.
    """
    if RUNNING in table or "displacement_mm" not in table or RUNNING not in force or not force["time_s"].size:
        return table
    row = np.minimum(np.searchsorted(force["time_s"], table["time_s"]), force["time_s"].size - 1)
    known = (force["time_s"][row] == table["time_s"]) & (table["time_s"] > force["time_s"][0])
    before = np.where(known, force["displacement_mm"][row] - force[RUNNING][row], 0.0)
    within = table["displacement_mm"]
    steps = table.get("step", np.where(known, force["step"][row], ""))
    return {**table, "displacement_mm": before + within, "step": steps, RUNNING: within}
