"""Friction that follows a schedule, in runs of either model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import knotfem as kf
from knotfem.contact.friction import Friction
from knotfem.errors import InputError
from knotfem.models.build import build_model
from knotfem.scene import load_scene

COARSE = (
    "rods.0.length=400 mm", "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm",
    "contact.sample_spacing_over_diameter=0.5", "output.fields=false", "tie.path=direct", "solver.threads=1",
)  # fmt: skip
MODELS = ("fem", "rod")
RISING = "friction_schedule=[{time='0 s', friction=0}, {time='5 s', friction=0.33}]"


def relaxing(*overrides: str):
    return load_scene("overhand", [*COARSE, f"steps=[{{kind='relax', {RISING}}}]", *overrides])


@pytest.mark.parametrize("model", MODELS)
def test_a_rod_is_not_at_rest_before_its_schedule_has_run_out(model: str) -> None:
    run = kf.pull(relaxing(f"model={model}"))
    assert run.stored.times[-1] >= 5.0


@pytest.mark.parametrize("model", MODELS)
def test_a_schedule_scales_all_pairs_of_rods(model: str) -> None:
    """It says what `contact.friction` becomes; a pair of its own keeps its proportion to that."""
    scene = relaxing(f"model={model}", "contact.pairs=[{between=['rod','rod'], friction=0.66}]")
    built = build_model(scene)
    (friction,) = [term for term in built.terms if isinstance(term, Friction)]
    *_, tied = built.mapping(built.paths(), "auto")
    flattened = tied.state.x * np.array([1.0, 0.3, 1.0, 1.0][: built.width])
    origin, later = (replace(tied.state, x=flattened, time=time) for time in (1.0, 1.5))
    system = built.equations(scene.steps[0], origin, {}).system
    system.begin(later, 2.0)
    assert friction.mu.size > 10
    assert friction.mu == pytest.approx(np.full(friction.mu.size, 0.66 * 2.5 / 5.0))
    system.close()


@pytest.mark.parametrize(
    "step",
    [
        "{kind='hold', duration='4 s', %s}",
        "{kind='relax', longest='4 s', %s}",
        "{kind='pull', displacement='16 mm', speed='4 mm/s', %s, "
        "ends={rod={start={motion='driven',direction=[0,0,1]}}}}",
    ],
)
def test_a_schedule_that_outlasts_its_step_is_refused(step: str) -> None:
    message = r"steps\.0\.friction_schedule: outlasts the step; found 5 s; expected at most 4 s"
    with pytest.raises(InputError, match=message):
        load_scene("overhand", [f"steps=[{step % RISING}]"])
