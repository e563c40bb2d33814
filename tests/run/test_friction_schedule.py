"""Friction that follows a schedule, in runs of either model."""

from __future__ import annotations

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.models.base import make_simulation
from knotfem.run import driver
from knotfem.run.directory import RunDirectory
from knotfem.scene import load_scene
from knotfem.solver.stepping.integrator import Progress
from knotfem.solver.term import Motion, StepStart

COARSE = (
    "rods.0.length=400 mm", "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=10 mm",
    "contact.sample_spacing_over_diameter=0.5", "output.fields=false", "tie.path=direct", "solver.threads=1",
)  # fmt: skip
MODELS = ("fem", "rod")
RISING = "friction_schedule=[{time='0 s', friction=0}, {time='5 s', friction=0.33}]"


def relaxing(*overrides: str):
    return load_scene("overhand", [*COARSE, f"steps=[{{kind='relax', {RISING}}}]", *overrides])


@pytest.mark.parametrize("model", MODELS)
def test_a_rod_is_not_at_rest_before_its_schedule_has_run_out(tmp_path, model: str) -> None:
    scene = relaxing(f"model={model}")
    run = RunDirectory.create(scene, tmp_path / "run")
    driver.pull(scene, run)
    assert run.read_status()["time_s"] >= 5.0


@pytest.mark.parametrize("model", MODELS)
def test_a_schedule_scales_all_pairs_of_rods(model: str) -> None:
    """It says what `contact.friction` becomes; a pair of its own keeps its proportion to that."""
    scene = relaxing(f"model={model}", "contact.pairs=[{between=['rod','rod'], friction=0.66}]")
    simulation = make_simulation(scene)
    (friction,) = simulation.named("friction")
    motion = Motion.at_rest(simulation.straight().x, 1.5)
    step = simulation.equations(scene.steps[0], 1.0, motion.x, {}, Progress.at(motion))
    friction.contact.pairs = np.zeros((1, 2), dtype=np.int64)
    friction.begin(StepStart(motion, 2.0))
    assert friction.mu == pytest.approx([0.66 * 2.5 / 5.0])
    step.system.close()


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
