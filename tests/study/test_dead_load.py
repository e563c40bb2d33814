"""The protocol of a dead load, for any scene."""

import pytest

import knotfem as kf
from knotfem.errors import InputError
from knotfem.scene.steps import Clamped, Free, Loaded
from knotfem.stability.ends import free_ends, loaded_ends
from knotfem.study.dead_load import Lowering, dead_load


def test_the_unit_of_force_is_b_over_r_squared():
    scene = kf.load_scene("bowline")
    assert scene.force_scale == pytest.approx(10.07, rel=1e-3)


def test_the_pull_of_the_shipped_scene_is_replaced():
    scene = dead_load("bowline", 1.1, friction=0.2)
    assert [step.name for step in scene.steps] == ["relax", "load", "let-go"]
    assert [step.name for step in scene.tying_steps] == ["relax"]
    load, let_go = scene.steps[1:]
    start, end = load.all_ends()["rod", "start"], load.all_ends()["rod", "end"]
    assert isinstance(start, Loaded)
    assert (start.force, start.direction, type(end)) == (1.1, (0.0, 0.0, 1.0), Clamped)
    small = let_go.all_ends()["rod", "end"]
    assert isinstance(small, Loaded)
    assert small.force == pytest.approx(0.055)
    assert small.direction == (0.0, 0.0, -1.0)
    assert [step.until for step in scene.steps[1:]] == ["decided", "decided"]
    assert scene.contact.friction == 0.2
    assert scene.gravity is None


def test_weight_a_ramp_and_no_small_load():
    scene = dead_load("bowline", "1.1 N", {"contact.friction": 0.3}, ramp="5 s", free_load=0.0, weight=True)
    assert [step.name for step in scene.steps] == ["relax", "load", "rest", "let-go"]
    assert isinstance(scene.steps[-1].all_ends()["rod", "end"], Free)
    assert scene.gravity is not None
    assert scene.contact.friction == 0.3


def test_friction_is_lowered_after_the_free_end_is_let_go():
    scene = dead_load("bowline", 1.1, friction=0.35, lowering=Lowering(rate=0.05, to=0.05))
    (first, last), step = scene.steps[-1].friction_schedule, scene.steps[-1]
    assert (step.name, first.friction, last.friction) == ("lower", 0.35, 0.05)
    assert last.time == pytest.approx(6.0)
    assert scene.output.every_time == pytest.approx(0.2)


def test_several_rods_and_ends_of_the_users_choice():
    scene = dead_load("sheet-bend", 1.0)
    assert loaded_ends(scene.steps[-1]) == [("hitch", "start")]
    assert free_ends(scene.steps[-1]) == [("hitch", "end"), ("bight", "end")]
    chosen = dead_load("clove-hitch", 1.0, loaded={"rod.end": [-1, 0, 0]}, free={"rod.start": [0, 0, -1]})
    assert loaded_ends(chosen.steps[-1]) == [("rod", "end")]
    assert free_ends(chosen.steps[-1]) == [("rod", "start")]


def test_something_must_bear_the_load():
    with pytest.raises(InputError, match="nothing bears the load"):
        dead_load("overhand", 1.0)


def test_without_a_free_end_the_other_ends_are_let_go():
    assert free_ends(dead_load("clove-hitch", 1.0).steps[-1]) == [("rod", "end")]


@pytest.mark.parametrize(
    ("scene", "arguments", "message"),
    [
        ("bowline", {"loaded": {"rod.middle": [0, 0, 1]}}, "no such end; found rod.middle"),
        ("bowline", {"loaded": {"rod.end": [0, 0, 1]}, "free": {"rod.end": [0, 0, 1]}}, "both loaded and free"),
        ("bowline", {"lowering": Lowering(to=0.5)}, "friction does not fall"),
        (kf.load_scene("bowline", {"steps": [{"kind": "relax"}]}), {}, "no end is loaded"),
    ],
)
def test_what_cannot_be_loaded_is_refused(scene, arguments, message):
    with pytest.raises(InputError, match=message):
        dead_load(scene, 1.0, **arguments)
