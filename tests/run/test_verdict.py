"""Whether a knot holds, in whole runs of discrete rods."""

from collections.abc import Iterator
from contextlib import suppress

import pytest
from coarse import HITCH

import knotfem as kf
from knotfem.errors import Stopped
from knotfem.results.run import Run
from knotfem.run.stop import StopRequest
from knotfem.scene.model import Scene
from knotfem.study.dead_load import dead_load


def hitch(friction: float, **changes) -> Scene:
    """The clove hitch under a dead load of 1 N, its short end let go."""
    quick = {**HITCH, "quasi_static.settling_slip_over_diameter": 0.1}
    return dead_load("clove-hitch", 1.0, {**quick, "obstacles.0.friction": friction, **changes}, friction=friction)


@pytest.fixture(scope="module")
def held() -> Run:
    return kf.pull(hitch(0.6), progress=False)


@pytest.fixture(scope="module")
def lost() -> Run:
    return kf.pull(hitch(0.05), progress=False)


def test_a_rough_hitch_holds(held):
    assert (held.verdict, held.failure_mode) == ("holds", "none")
    evidence = held.verdict_evidence
    assert evidence["at_rest"]
    assert evidence["lost"] is None
    assert evidence["in_words"].startswith("the knot holds: it came to rest under the load")
    assert set(evidence["travel_in_last_step"]["free_ends_mm"]) == {"rod.end"}


def test_a_slippery_hitch_unravels_and_ends_the_run(lost):
    assert lost.verdict == "unravels"
    evidence = lost.verdict_evidence
    assert evidence["lost"]["what"] == "the hitch of rod has come undone"
    assert evidence["lost"]["friction"] == 0.05
    assert not evidence["at_rest"]
    assert lost.table("force")["time_s"][-1] == evidence["lost"]["time_s"]


def test_forces_and_displacements_are_those_of_all_steps_after_tying(held):
    table = held.table("force")
    load, let_go = (table["step"] == name for name in ("load", "let-go"))
    assert table["force_N"][load] == pytest.approx(1.0)
    assert table["displacement_mm"][load][-1] > 1.0
    assert table["displacement_mm"][let_go][0] == pytest.approx(table["displacement_mm"][load][-1], abs=1.0)
    assert (load | let_go).all()


def test_a_force_curve_has_equilibria_only(lost):
    table = lost.table("force")
    balanced = table["equilibrium"] > 0
    assert 0 < balanced.sum() < balanced.size
    assert lost.force.drawn[0].tolist() == table["displacement_mm"][balanced].tolist()


def test_a_step_may_go_on_after_the_verdict(lost):
    steps = hitch(0.05).model_dump(mode="json", exclude_none=True)["steps"]
    until_end = kf.load_scene(hitch(0.05), {"steps": [{**step, "until": "end"} for step in steps]})
    run = kf.pull(until_end, progress=False)
    assert run.verdict == "unravels"
    assert run.verdict_evidence["lost"] == lost.verdict_evidence["lost"]
    assert run.cost.steps > lost.cost.steps


def test_the_verdict_of_a_resumed_run_is_the_same(tmp_path, monkeypatch, lost):
    asked = iter(range(10**6))
    monkeypatch.setattr(StopRequest, "due", property(lambda self: next(asked) % 97 == 96))

    def attempts() -> Iterator[Run]:
        with suppress(Stopped):
            yield kf.pull(hitch(0.05), out=tmp_path / "run")
        while True:
            try:
                yield kf.resume(tmp_path / "run")
            except Stopped:
                continue

    run = next(attempts())
    assert next(asked) > 300
    assert run.verdict_evidence == lost.verdict_evidence
    assert kf.open_run(tmp_path / "run").verdict == "unravels"


def test_a_rod_over_a_cylinder_slips():
    changed = {"rods.0.mesh.element_length": "3 mm", "obstacles.0.friction": 0.05, "steps.pull.displacement": "13 mm"}
    run = kf.pull("capstan", {"model": "rod", "output.fields": False, **changed}, progress=False)
    assert (run.verdict, run.failure_mode) == ("slips", "wrapping")
    assert run.verdict_evidence["fraction_of_last_displacement"] > 0.9
    assert run.summary["knot_after"].startswith("hitch round cylinder (")


def test_without_a_free_end_there_is_no_verdict():
    run = kf.pull("overhand", {**HITCH, "steps.pull.displacement": "1 mm"}, progress=False)
    assert run.verdict is None
    assert run.verdict_evidence == {}


def test_a_run_that_only_ties_has_no_verdict():
    assert kf.tie(hitch(0.35), progress=False).verdict is None


def test_where_the_knot_must_hold_its_loss_is_an_error():
    scene = hitch(0.05)
    steps = [step.model_dump(mode="json", exclude_none=True) for step in scene.steps]
    steps[-1]["must_hold"] = True
    with pytest.raises(kf.KnotLost, match="let-go: the hitch of rod has come undone") as raised:
        kf.pull(kf.load_scene(scene, {"steps": steps}), progress=False)
    run = raised.value.run
    assert isinstance(run, kf.Run)
    assert run.verdict == "unravels"
