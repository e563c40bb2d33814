"""The energy account where an end is let go."""

from __future__ import annotations

import pytest

from knotfem.scene import load_scene
from knotfem.verify.rehearsal import Rehearsal

BENT = (
    "rods.0.centerline=capstan_half", "rods.0.length=240 mm",
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm", "rods.0.core=none",
    "contact.enabled=false", "tie.increments=2", "drag.rate=10 1/s",
)  # fmt: skip
LET_GO = ("steps.1={kind='hold', duration='1 s', ends={rod={end={motion='free'}}}}",)


@pytest.mark.parametrize("scheme", ["backward-euler", "hht", "generalised-alpha"])
def test_energy_of_an_end_let_go_is_not_missing(scheme: str) -> None:
    """Whatever weights a scheme gives to the forces it balances, and where they jump as the end is let go."""
    rehearsal = Rehearsal(load_scene("overhand", [*BENT, *LET_GO, f"inertia.scheme={scheme}"]))
    for passed in rehearsal.run(rehearsal.tied()):
        energies = rehearsal.account.energies
        if passed.step.kind == "hold":
            assert abs(passed.missing) < 1e-3 * energies.stored_at_start
            if energies.elastic < 0.9 * energies.stored_at_start:
                return
    pytest.fail("the end has not moved")
