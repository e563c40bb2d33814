"""Large steps and loose tolerances: the error stays within what the settings promise, or the run reports a failure."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from knotfem.errors import InputError
from knotfem.scene import Scene
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.outcome import Outcome
from knotfem.verify.stress.runs import SLIGHT, hard_case, hard_scene, run

PROMISED = {"large-steps": 0.05, "loose-tolerance": 0.02}
"""Largest error of the force over the largest force: from friction, which depends on the path, in the largest steps
allowed; from a residual 100 times the usual one, 0.01 N along the rod against a force of 0.5 N."""
FAILURES = ("NotConverged", "KnotLost")
"""Errors by which a run reports that it has no result."""
TOO_LARGE = 8.0 * 0.5
"""Eight times the usual `solver.move_over_diameter`."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
    titles = {
        "large-steps": "time step 8 times too large: refused; the largest there is: within its error",
        "loose-tolerance": "Newton's tolerance 100 times too loose",
    }
    scenes = {name: hard_scene(name, SLIGHT if small else (), small=small) for name in titles}
    return [
        hard_case(
            "settings", name, title, partial(_against_usual, name, scenes[name], small), scenes[name], small=small
        )
        for name, title in titles.items()
    ]


@cache
def _usual(small: bool) -> Outcome:
    settings = ("solver.move_over_diameter=0.5", "solver.force_tolerance=1e-5 N")
    return run(hard_scene("large-steps", (*settings, *(SLIGHT if small else ())), small=small))


def _against_usual(name: str, scene: Scene, small: bool) -> Sequence[Quantity]:
    usual, found = _usual(small), run(scene)
    expected = usual.quantities(before="3_1", after="3_1", condition="usual")
    if not usual.finished:
        return expected
    if not found.finished:
        by = found.ended.partition(":")[0]
        said = Quantity("said to have failed", by in FAILURES, True, kind="equal", condition=found.ended)
        return [*expected, said]
    promised = 5.0 * PROMISED[name] if small else PROMISED[name]
    return [
        *found.quantities(before="3_1", after="3_1", energy=promised),
        Quantity("error of the force over the force", force_error(found, usual), promised, kind="at most"),
        *([_refused()] if name == "large-steps" else []),
    ]


def _refused() -> Quantity:
    try:
        hard_scene("large-steps", (f"solver.move_over_diameter={TOO_LARGE}",))
        said = "accepted"
    except InputError as error:
        said = str(error)
    return Quantity("8 times too large: refused", "move_over_diameter" in said, True, kind="equal", condition=said)


def force_error(found: Outcome, usual: Outcome) -> float:
    """Largest difference of two force curves over the largest force, at the displacements of the second."""
    curves = []
    for outcome in (found, usual):
        rows = outcome.force["step"] == outcome.force["step"][-1]
        curves.append((outcome.force["step_displacement_mm"][rows], outcome.force["force_N"][rows]))
    (there, force), (displacement, expected) = curves
    on_both = displacement >= there[0]
    difference = np.interp(displacement[on_both], there, force) - expected[on_both]
    return float(np.abs(difference).max() / np.abs(expected).max())
