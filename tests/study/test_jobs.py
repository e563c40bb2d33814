"""Runs of refinement levels: order, budget, what is kept and what is tried again; the engine is a stand-in."""

import time
from pathlib import Path
from typing import Any

import pytest
from manufactured import write_run
from stand_in import StandIn

from knotfem.errors import InputError
from knotfem.run.expected import Expected
from knotfem.scene import load_scene
from knotfem.study import jobs as module
from knotfem.study.engine.engine import Job
from knotfem.study.engine.outcomes import CRASHED, Outcome
from knotfem.study.engine.places import Local
from knotfem.study.jobs import Jobs
from knotfem.study.refinement import Level, base_level

FINE = Level("fine", "slice", "1 mm", 0.5, ("rods.0.mesh.element_length=1 mm",))
COARSE = Level("coarse", "slice", "4 mm", 2.0, ("rods.0.mesh.element_length=4 mm",))


def scene_of(level: Level):
    return load_scene("overhand", level.overrides)


class Listened(Jobs):
    """Jobs that keep what they tell."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self.told: list[str] = []
        super().__init__(*arguments, tell=self.told.append, **settings)


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Jobs on an engine whose runs do as they are told; the engine that they used last is its attribute."""

    def build(plan: dict[str, dict[str, Any]] | None = None, workers: int = 1, **settings: Any) -> Listened:
        engines: list[StandIn] = []

        def act(job: Job) -> Outcome:
            told = (plan or {}).get(job.name, {"state": "done"})
            return Outcome(told["state"], told.get("reason", ""), told.get("code", 0))

        def engine(*arguments: Any, **others: Any) -> StandIn:
            engines.append(StandIn(act, workers))
            return engines[-1]

        monkeypatch.setattr(module, "Engine", engine)
        jobs = Listened(tmp_path, scene_of, Local(workers), **settings)
        jobs.engines = engines  # pyright: ignore[reportAttributeAccessIssue]
        return jobs

    return build


def lasting(seconds: float) -> Expected:
    return Expected(1000, seconds, seconds, 512.0)


def order(jobs: Any) -> list[str]:
    return [name for engine in jobs.engines for name in engine.order]


def test_scene_first_then_by_expected_cost(make, tmp_path):
    jobs = make()
    jobs.run([FINE, base_level(), COARSE])
    assert order(jobs) == ["base", "coarse", "fine"]
    assert {name: outcome.state for name, outcome in jobs.outcomes.items()} == dict.fromkeys(
        ("base", "coarse", "fine"), "done"
    )
    assert load_scene(tmp_path / "runs" / "fine" / "scene.toml") == scene_of(FINE)
    assert jobs.engines[0].jobs["fine"].time_limit is None


def test_budget_leaves_out_what_does_not_fit_and_says_so(make, monkeypatch):
    monkeypatch.setattr(module, "expected", lambda scene: lasting(999.0 if scene == scene_of(FINE) else 0.0))
    jobs = make(deadline=time.monotonic() + 60.0)
    jobs.run([FINE, base_level(), COARSE])
    assert order(jobs) == ["base", "coarse"]
    assert jobs.outcomes["fine"].state == "left out"
    assert "16.7 min" in jobs.outcomes["fine"].reason
    assert any(text.startswith("fine: left out") for text in jobs.told)
    assert 50.0 < jobs.engines[0].jobs["base"].time_limit <= 60.0


def test_pace_of_what_is_done_corrects_what_is_expected(make, monkeypatch):
    monkeypatch.setattr(module, "expected", lambda scene: lasting(9.0))
    monkeypatch.setattr(module, "spent", lambda run: 29.0 if run.path.name == "base" else 0.0)
    jobs = make()
    assert jobs.expected(FINE) == 10.0
    jobs.run([base_level()])
    assert jobs.expected(FINE) == pytest.approx(30.0)


def test_a_level_is_begun_only_when_a_worker_is_free(make):
    jobs = make(workers=2)
    jobs.run([base_level(), COARSE, FINE])
    assert jobs.engines[0].most == 2
    assert [state for state in (outcome.state for outcome in jobs.outcomes.values())] == ["done"] * 3


def test_failure_is_an_outcome_and_a_crash_is_none(make):
    lost = {"state": "failed", "reason": "strands passed", "code": 5}
    crashed = {"state": "failed", "reason": "crashed: MemoryError()", "code": CRASHED}
    jobs = make({"coarse": lost, "fine": crashed})
    jobs.run([base_level(), COARSE, FINE])
    assert jobs.outcomes["coarse"] == Outcome("failed", "strands passed", 5)
    assert jobs.outcomes["fine"] == Outcome("failed", "crashed: MemoryError()", CRASHED)
    again = make()
    again.run([COARSE, FINE])
    assert order(again) == ["fine"]
    assert again.outcomes["coarse"].state == "failed", "a failure is a result"
    assert again.outcomes["fine"].state == "done", "a crash is none"


def test_level_that_is_no_scene_has_failed(make):
    wrong = Level("wrong", "slice", "", 3.0, ("rods.0.mesh.element_length=400 mm",))
    jobs = make()
    jobs.run([wrong, base_level()])
    assert order(jobs) == ["base"]
    assert "too long for the rod" in jobs.outcomes["wrong"].reason
    with pytest.raises(InputError):
        make().run([Level("base", "base", "", 1.0, wrong.overrides)])


def test_runs_say_how_much_memory_they_take(make, monkeypatch):
    monkeypatch.setattr(module, "expected", lambda scene: lasting(1.0))
    jobs = make()
    jobs.run([base_level()])
    assert jobs.engines[0].jobs["base"].memory_mb == 512.0


def test_nothing_is_started_once_the_scene_itself_fails(make):
    jobs = make({"base": {"state": "failed", "code": 4}})
    jobs.run([base_level(), COARSE])
    assert order(jobs) == ["base"]
    assert jobs.outcomes["coarse"] == Outcome("left out", "the scene itself fails")


def test_what_is_done_is_kept_and_the_rest_goes_on(make):
    first = make({"coarse": {"state": "stopped"}})
    write_run(first.run_of(base_level()), scene_of(base_level()))
    first.run([base_level(), COARSE])
    assert order(first) == ["coarse"]
    assert first.outcomes["coarse"].state == "stopped"
    again = make()
    again.run([base_level(), COARSE])
    assert order(again) == ["coarse"]
    assert again.outcomes["coarse"].state == "done"
    known = make()
    known.run([base_level(), COARSE])
    assert known.engines == [], "no engine is started for what is known"


def test_run_of_another_scene_is_not_taken(make):
    jobs = make()
    write_run(jobs.run_of(COARSE), scene_of(base_level()))
    with pytest.raises(InputError, match="another scene"):
        jobs.run([COARSE])
    threads = load_scene("overhand", [*FINE.overrides, "solver.threads=2"])
    write_run(jobs.run_of(FINE), threads)
    jobs.run([FINE])
