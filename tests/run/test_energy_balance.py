"""The energy balance of whole runs: where an end is let go, and what it says of schemes."""

from __future__ import annotations

import numpy as np
import pytest

import knotfem as kf

BENT = (
    "rods.0.centerline=capstan_half", "rods.0.length=240 mm",
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm", "rods.0.core=none",
    "contact.enabled=false", "tie.increments=2", "drag.rate=10 1/s", "output.fields=false", "solver.threads=1",
)  # fmt: skip
LET_GO = (
    "steps.0={kind='hold', name='settle', duration='5 s'}",
    "steps.1={kind='hold', duration='0.15 s', ends={rod={end={motion='free'}}}}",
)


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize("scheme", ["backward-euler", "hht", "generalised-alpha"])
def test_energy_of_an_end_let_go_is_not_missing(model: str, scheme: str) -> None:
    """Whatever weights a scheme gives to the forces it balances, and where they jump as the end is let go."""
    table = kf.pull("overhand", [*BENT, *LET_GO, f"inertia.scheme={scheme}", f"model={model}"]).table("force")
    let_go = np.flatnonzero(np.array(table["step"]) == "hold")
    elastic, missing = np.array(table["elastic_Nmm"])[let_go[0] - 1 :], np.array(table["missing_Nmm"])[let_go[0] - 1 :]
    assert elastic[-1] < 0.9 * elastic[0]
    assert np.abs(np.diff(missing)).max() < 1e-3 * elastic[0]


@pytest.mark.parametrize("model", ["fem", "rod"])
@pytest.mark.parametrize("scheme", ["hht", "generalised-alpha"])
def test_a_rod_comes_to_rest_under_schemes_that_keep_energy(model: str, scheme: str) -> None:
    """Clamped and bent; with the energy kept it would ring for as long as it may."""
    steps = "steps=[{kind='relax', longest='20 s'}]"
    run = kf.tie("overhand", [*BENT, steps, f"inertia.scheme={scheme}", f"model={model}"])
    assert run.stored.times[-1] < 10.0
