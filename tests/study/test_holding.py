"""Tighten, let go, pull until it slips."""

import numpy as np
import pytest
from coarse import HITCH

import knotfem as kf
from knotfem.errors import InputError
from knotfem.results.run import Run
from knotfem.run.summary_meanings import SUMMARY
from knotfem.scene.steps import Clamped, Driven, Free, Loaded, Pull
from knotfem.study.holding import holding_scene


@pytest.fixture(scope="module")
def hitch() -> Run:
    return kf.hold("clove-hitch", HITCH, tighten="1 N", slip="3 mm", progress=False)


def test_the_recipe():
    scene = holding_scene("clove-hitch", "2 N", slip="3 mm", free_load=0.05)
    tighten, let_go, pull = scene.steps[1:]
    assert [step.name for step in scene.steps] == ["relax", "tighten", "let-go", "pull"]
    start, end = tighten.all_ends()["rod", "start"], tighten.all_ends()["rod", "end"]
    assert isinstance(start, Loaded)
    assert (start.force, type(end)) == (2.0, Clamped)
    assert isinstance(let_go.all_ends()["rod", "start"], Clamped)
    assert isinstance(pull, Pull)
    assert (pull.slip, pull.displacement) == (3.0, 15.0)
    assert isinstance(pull.all_ends()["rod", "start"], Driven)
    small = pull.all_ends()["rod", "end"]
    assert isinstance(small, Loaded)
    assert small.force == pytest.approx(0.1)


def test_without_tightening_and_small_load():
    scene = holding_scene("clove-hitch", 0.0)
    assert [step.name for step in scene.steps] == ["relax", "let-go", "pull"]
    assert isinstance(scene.steps[-1].all_ends()["rod", "end"], Free)


def test_a_length_that_is_none_is_refused():
    with pytest.raises(InputError):
        holding_scene("clove-hitch", "2 N", slip="3 s")


def test_the_step_ends_once_the_end_is_drawn_in(hitch):
    table = hitch.table("force")
    drawn = table["drawn_in_mm"][table["step"] == "pull"]
    assert 3.0 < drawn[-1] < 4.0
    assert (drawn[:-1] <= 3.0).all()
    assert hitch.verdict == "slips"
    assert table["step_displacement_mm"][-1] < 15.0


def test_the_force_on_the_held_end_is_told_while_the_free_end_is_let_go(hitch):
    table = hitch.table("force")
    tighten, let_go, pull = (np.flatnonzero(table["step"] == name) for name in ("tighten", "let-go", "pull"))
    assert table["force_N"][tighten] == pytest.approx(1.0)
    assert table["force_N"][let_go[0]] == pytest.approx(1.0, rel=0.1)
    assert table["force_N"][let_go[-1]] == pytest.approx(table["force_N"][pull[0]], rel=0.5)
    assert (table["displacement_mm"][let_go] == table["displacement_mm"][tighten[-1]]).all()


def test_the_reference_has_all_that_is_said_of_verdict_and_holding(hitch):
    for table in ("verdict_evidence", "holding"):
        assert {f"{table}.{key}" for key in hitch.summary[table]} <= set(SUMMARY)


def test_as_much_is_drawn_in_as_samples_in_contact_move_along_the_rod(hitch):
    before, after = (hitch.contacts(step=step)["arclength_mm"].max() for step in ("let-go", "pull"))
    assert after - before == pytest.approx(hitch.table("force")["drawn_in_mm"][-1], abs=1.0)


def test_force_of_the_summary_and_of_the_curve_are_one(hitch):
    found, figures = hitch.holding(), hitch.summary["holding"]
    assert found is not None
    assert figures["holding_force_N"] == found.force
    assert figures["slipping_force_N"] == found.slip_force
    equilibria = hitch.force.steps["pull"][1]
    assert found.force <= equilibria.max() * (1.0 + 1e-12)
    less = hitch.holding("1 mm")
    assert less is not None
    assert less.slip_displacement < found.slip_displacement
    with pytest.raises(InputError, match="no slip"):
        hitch.holding(-1.0)


def test_a_run_without_free_ends_holds_nothing_that_is_known():
    run = kf.pull("overhand", {**HITCH, "steps.1.displacement": "1 mm"}, progress=False)
    assert run.holding() is None
    assert "drawn_in_mm" not in run.table("force")
