"""Limits of the time step in units of the rod."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.run.schedule import Schedule, schedule_of
from knotfem.scene import load_scene
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.quasi_static import QuasiStatic


def of_scene(*overrides: str, step: int = 1, began: float = 0.0) -> Schedule:
    scene = load_scene("overhand", overrides)
    model: Any = SimpleNamespace(scene=scene, diameter=6.0, mass=2e-5, force_scale=10.0)
    return schedule_of(model, scene.steps[step], began)


def control_of(*overrides: str) -> StepController:
    pacing = of_scene(*overrides).pacing
    assert isinstance(pacing, QuasiStatic)
    return pacing.loads


def test_driven_end_moves_at_most_as_far_as_the_scene_says():
    assert control_of().move == pytest.approx(3.0)
    fine = control_of("solver.move_over_diameter=0.0625")
    assert fine.move == pytest.approx(0.375)
    assert fine.first == pytest.approx(0.1 / 4.0)


def test_first_step_is_no_longer_than_the_limit():
    control = control_of("solver.move_over_diameter=0.01")
    assert 4.0 * control.first == pytest.approx(control.move) == 0.06


def test_outputs_are_due_at_even_displacements_and_at_the_end():
    schedule = of_scene("steps.1.displacement=10 mm", "output.every_displacement=4 mm", began=3.0)
    assert schedule.output_times == pytest.approx([4.0, 5.0, 5.5])
    assert [schedule.fraction(3.0, time) for time in (3.0, 4.25, 5.5)] == pytest.approx([0.0, 0.5, 1.0])
    assert [schedule.over(time) for time in (5.4, 5.5)] == [False, True]


def test_relaxing_in_real_time_has_no_outputs_on_its_way():
    schedule = of_scene("steps.0.longest=40 s", "steps.0.rate=real", step=0)
    assert schedule.output_times.tolist() == [40.0]
    assert isinstance(schedule.pacing, StepController)
    assert schedule.pacing.largest == 40.0


def test_relaxing_takes_as_long_as_the_rods_take_to_settle():
    schedule = of_scene("steps.0.longest=40 s", step=0, began=2.0)
    assert schedule.output_times.tolist() == [3.0]
    assert np.isnan(schedule.fraction(2.0, 2.0))
    assert schedule.over(3.0)


def test_relaxing_lasts_to_the_end_of_its_schedule():
    points = '[{ time = "0 s", friction = 0.2 }, { time = "3 s", friction = 0.1 }]'
    schedule = of_scene(f"steps.0.friction_schedule={points}", step=0, began=2.0)
    assert schedule.output_times.tolist() == [5.0]


def test_what_may_be_carried_is_a_fraction_of_the_load_and_never_less_than_the_balance_tolerates():
    pacing = of_scene("quasi_static.tolerance=0.01", "solver.force_tolerance=1e-6 N").pacing
    assert isinstance(pacing, QuasiStatic)
    assert pacing.allowance(2.0) == pytest.approx(0.02)
    assert pacing.allowance(0.0) == pytest.approx(1e-5)


def test_a_pull_in_real_time_needs_a_speed():
    with pytest.raises(InputError, match="missing key"):
        load_scene("overhand", ["steps.1.rate=real", "steps.1.speed=none"])
    assert isinstance(of_scene("steps.1.rate=real").pacing, StepController)
    assert of_scene("steps.1.speed=none", "steps.1.displacement=7 mm").output_times[-1] == pytest.approx(7.0)


def test_steps_are_cut_as_often_as_the_scene_says():
    controller = control_of("solver.max_cutbacks=2")
    assert controller.smallest == pytest.approx(0.4**2 * controller.first)
