"""Limits of the time step in units of the rod."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.run.stepping import Underway, march_of
from knotfem.scene import load_scene
from knotfem.solver.stepping.integrator import StepControl


def control_of(*overrides: str, step: int = 1) -> StepControl:
    scene = load_scene("overhand", overrides)
    model: Any = SimpleNamespace(scene=scene, diameter=6.0, sections=np.zeros(1, dtype=int))
    nothing: Any = None
    return march_of(model, scene.steps[step], nothing, nothing, 0.0).control


def test_driven_end_moves_at_most_as_far_as_the_scene_says():
    assert control_of().move == pytest.approx(3.0)
    fine = control_of("solver.move_over_diameter=0.0625")
    assert fine.move == pytest.approx(0.375)
    assert fine.first == pytest.approx(0.1 / 4.0)


def test_first_step_is_no_longer_than_the_limit():
    control = control_of("solver.move_over_diameter=0.01")
    assert 4.0 * control.first == pytest.approx(control.move) == 0.06


def test_checkpoint_of_an_older_version_amid_a_load_is_refused():
    load = load_scene("capstan").steps[1]
    with pytest.raises(InputError, match=r"steps\.load: the checkpoint is of an older version"):
        Underway.restored(load, {"began": 0.0})
