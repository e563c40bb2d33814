"""What a step does to ends and friction, as functions of time."""

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.models.conditions import following_sign, force_history, friction_factor, gravity_of, make_scheme, ramp
from knotfem.scene import Scene, load_scene
from knotfem.scene.steps import Pull
from knotfem.solver.schemes import BackwardEuler, GeneralisedAlpha, Scheme

HOLD = 'steps=[{kind="relax"},{kind="hold",duration="2 s",friction_schedule=[%s]},{kind="hold",duration="1 s"}]'
REAL = "steps.0.rate=real", "steps.1.rate=real"
FALLING = '{time="0 s",friction=0.3},{time="2 s",friction=0.15}'


def holding(schedule: str) -> Scene:
    return load_scene("overhand", [HOLD % schedule, "contact.friction=0.3"])


def test_driven_end_goes_as_far_as_the_step_says():
    step = load_scene("overhand").steps[1]
    assert isinstance(step, Pull)
    path = ramp(step, 5.0)
    assert [path(5.0), path(6.0), path(1000.0)] == [0.0, 4.0, 120.0]


def test_load_rises_from_what_it_was_and_other_steps_act_in_full():
    relax, load, _ = load_scene("capstan").steps
    history = force_history(3.0, 1.0, load, 10.0)
    assert [history(10.0), history(11.0), history(12.0), history(13.0)] == [1.0, 2.0, 3.0, 3.0]
    assert force_history(3.0, 1.0, relax, 10.0)(10.0) == 3.0


def test_friction_follows_its_schedule_and_then_stays():
    scene = holding(FALLING)
    relax, falling, after = scene.steps
    assert friction_factor(scene, relax, 0.0) is None
    factor = friction_factor(scene, falling, 4.0)
    assert factor is not None
    assert [factor(4.0), factor(5.0), factor(6.0)] == pytest.approx([1.0, 0.75, 0.5])
    kept = friction_factor(scene, after, 6.0)
    assert kept is not None
    assert kept(6.5) == pytest.approx(0.5)


def test_following_force_pulls_outwards_or_inwards_and_never_across():
    up = np.array([0.0, 0.0, 1.0])
    assert following_sign(up, up, "rod.end") == 1.0
    assert following_sign(-up, up, "rod.end") == -1.0
    with pytest.raises(InputError, match=r"steps\.ends\.rod\.end\.direction"):
        following_sign(np.array([1.0, 0.0, 0.0]), up, "rod.end")


def test_gravity_acts_along_its_direction():
    scene = load_scene("bowline", ["gravity.direction=[3, 0, 4]"])
    assert gravity_of(scene) == pytest.approx([0.6 * 9810.0, 0.0, 0.8 * 9810.0])
    assert not gravity_of(load_scene("overhand")).any()


@pytest.mark.parametrize(
    ("inertia", "relaxing", "loading"),
    [
        ("scheme=quasi-static", Scheme, Scheme),
        ("scheme=backward-euler", BackwardEuler, BackwardEuler),
        ("scheme=hht", BackwardEuler, GeneralisedAlpha),
        ("scheme=generalised-alpha", BackwardEuler, GeneralisedAlpha),
    ],
)
def test_relaxing_takes_energy_whatever_loading_keeps(inertia, relaxing, loading):
    scene = load_scene("overhand", [*REAL, f"inertia.{inertia}"])
    relax, pull = scene.steps
    assert (type(make_scheme(scene, relax)), type(make_scheme(scene, pull))) == (relaxing, loading)
    assert (
        type(make_scheme(load_scene("overhand", [*REAL, f"inertia.{inertia}", "inertia.relaxing=hht"]), pull))
        is loading
    )


def test_there_is_no_inertia_where_there_is_no_real_time():
    scene = load_scene("overhand", ["steps.1.rate=real", "inertia.scheme=hht"])
    assert [type(make_scheme(scene, step)) for step in scene.steps] == [Scheme, GeneralisedAlpha]


def test_a_scene_may_relax_by_a_scheme_that_keeps_energy():
    scene = load_scene("overhand", [*REAL, "inertia.scheme=generalised-alpha", "inertia.relaxing=hht"])
    found = make_scheme(scene, scene.steps[0])
    assert isinstance(found, GeneralisedAlpha)
    assert found.alpha_f == pytest.approx(0.05)
