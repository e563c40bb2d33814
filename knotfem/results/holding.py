"""What a knot bore before it slipped, read off a run's force curve for any length of slip."""

from __future__ import annotations

import numpy as np

from knotfem.errors import InputError
from knotfem.results.base import RunData, displacement_of
from knotfem.run.columns import DRAWN_IN, RUNNING
from knotfem.stability.ends import free_ends
from knotfem.stability.holding import Holding, LoadingStep, slip_of


def holding_of(run: RunData, slip: float | str | None = None) -> Holding | None:
    """What the knot bore in the last step that pulled or loaded it while ends were free; None without such a step.

    Args:
        run: that has taken a loading step.
        slip: length that a free end may be drawn in by, [mm] or such as "3 mm"; None for the step's `slip`, or one
            diameter of the thinnest rod.

    Raises:
        InputError: the run does not tell how far ends were drawn in, or the length is not above 0.
    """
    table = run.table("force")
    if not table:
        return None
    taken = [
        step
        for step in run.scene.loading_steps
        if isinstance(step, LoadingStep) and free_ends(step) and (table["step"] == step.name).any()
    ]
    if not taken or not run.scene.contact.enabled:
        return None
    if DRAWN_IN not in table:
        raise InputError(
            "how far ends were drawn in is not stored", file=run.path, key=DRAWN_IN, expected="a run of this version"
        )
    step = taken[-1]
    thinnest = min(rod.diameter for rod in run.scene.rods)
    length = slip_of(step, thinnest) if slip is None else displacement_of(slip)
    if length is None or not length > 0.0:
        raise InputError("no slip", key="slip", found=str(slip), expected="a length above 0")
    found = Holding(length)
    for row in np.flatnonzero(table["step"] == step.name):
        found.update(
            float(table[RUNNING][row]),
            float(table["force_N"][row]),
            float(table[DRAWN_IN][row]),
            settled=bool(table["equilibrium"][row]),
        )
    return found
