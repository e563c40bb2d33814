"""Runs in processes, in order, within a budget; what is done is kept. The processes are stand-ins."""

import sys
from pathlib import Path
from typing import Any

import pytest
from manufactured import write_run

from knotfem.errors import InputError, Stopped
from knotfem.run.stop import StopRequest
from knotfem.scene import load_scene
from knotfem.study import jobs as module
from knotfem.study.jobs import Jobs, Outcome
from knotfem.study.refinement import Level, base_level

STAND_IN = """
import json, os, pathlib, sys, time
run = pathlib.Path(sys.argv[1])
with open(run.parents[1] / "order", "a") as order:
    order.write(run.name + "\\n")
plan = json.loads((run.parents[1] / "plan.json").read_text()).get(run.name, {})
(run / "seen.json").write_text(json.dumps({"limit": sys.argv[2:], "threads": os.environ["NUMBA_NUM_THREADS"]}))
time.sleep(plan.get("sleep", 0.0))
if "state" in plan:
    status = {"state": plan["state"], "reason": plan.get("reason", ""), "exit_code": plan.get("code", 0)}
    (run / "status.json").write_text(json.dumps(status))
if plan.get("code", 0) < 0:
    os.kill(os.getpid(), -plan["code"])
sys.exit(plan.get("code", 0))
"""
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
    """Jobs whose processes do as they are told."""
    script = tmp_path / "stand_in.py"
    script.write_text(STAND_IN)
    monkeypatch.setattr(module, "WORKER", (sys.executable, str(script)))
    monkeypatch.setattr(module, "POLL", 0.01)

    def build(plan: str = "{}", **settings) -> Listened:
        (tmp_path / "plan.json").write_text(plan)
        return Listened(tmp_path, scene_of, **{"processes": 1, "threads": 1, **settings})

    return build


def order(folder: Path) -> list[str]:
    path = folder / "order"
    return path.read_text().split() if path.exists() else []


def test_scene_first_then_by_expected_cost(make, tmp_path):
    jobs = make()
    jobs.run([FINE, base_level(), COARSE])
    assert order(tmp_path) == ["base", "coarse", "fine"]
    assert {name: outcome.state for name, outcome in jobs.outcomes.items()} == dict.fromkeys(
        ("base", "coarse", "fine"), "done"
    )
    assert load_scene(tmp_path / "runs" / "fine" / "scene.toml") == scene_of(FINE)
    assert (tmp_path / "runs" / "fine" / "seen.json").read_text() == '{"limit": [], "threads": "1"}'


def test_budget_leaves_out_what_does_not_fit_and_says_so(make, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "process_seconds", lambda scene: 1e3 if scene == scene_of(FINE) else 1.0)
    monkeypatch.setattr(module, "START_SECONDS", 1.0)
    jobs = make(deadline=module.time.monotonic() + 60.0)
    jobs.run([FINE, base_level(), COARSE])
    assert order(tmp_path) == ["base", "coarse"]
    assert jobs.outcomes["fine"].state == "left out"
    assert "16.7 min" in jobs.outcomes["fine"].reason
    assert any(text.startswith("fine: left out") for text in jobs.told)
    limit = (tmp_path / "runs" / "base" / "seen.json").read_text()
    assert 50.0 < float(limit.split('"')[3]) <= 60.0


def test_pace_of_what_is_done_corrects_what_is_expected(make, monkeypatch):
    monkeypatch.setattr(module, "process_seconds", lambda scene: 10.0)
    jobs = make()
    assert jobs.expected(FINE) == 10.0
    monkeypatch.setattr(module, "START_SECONDS", 30.0)
    jobs.run([base_level()])
    assert jobs.expected(FINE) == pytest.approx(30.0)


def test_failure_is_an_outcome(make):
    plan = '{"coarse": {"code": 5, "state": "failed", "reason": "strands passed"}, "fine": {"code": -9}}'
    jobs = make(plan)
    jobs.run([base_level(), COARSE, FINE])
    assert jobs.outcomes["coarse"] == Outcome("failed", "strands passed", 5)
    assert jobs.outcomes["fine"].exit_code == -9
    assert jobs.outcomes["fine"].state == "failed"
    assert "worker.log" in jobs.outcomes["fine"].reason
    again = make()
    again.run([COARSE, FINE])
    assert again.outcomes["coarse"].state == "failed", "a failure is a result"
    assert again.outcomes["fine"].state == "done", "a crash is none"


def test_crash_with_a_reason_is_tried_again(make):
    first = make('{"coarse": {"code": 1, "state": "failed", "reason": "MemoryError()"}}')
    first.run([base_level(), COARSE])
    assert "the process ended with 1, see" in first.outcomes["coarse"].reason
    again = make()
    again.run([COARSE])
    assert again.outcomes["coarse"].state == "done"


def test_process_ended_before_it_began_goes_on(make, tmp_path):
    first = make('{"coarse": {"code": -15}}')
    first.run([base_level(), COARSE])
    assert first.outcomes["coarse"].state == "stopped"
    again = make()
    again.run([base_level(), COARSE])
    assert order(tmp_path) == ["base", "coarse", "base", "coarse"]


def test_level_that_is_no_scene_has_failed(make, tmp_path):
    wrong = Level("wrong", "slice", "", 3.0, ("rods.0.mesh.element_length=400 mm",))
    jobs = make()
    jobs.run([wrong, base_level()])
    assert order(tmp_path) == ["base"]
    assert "too long for the rod" in jobs.outcomes["wrong"].reason
    with pytest.raises(InputError):
        make().run([Level("base", "base", "", 1.0, wrong.overrides)])


def test_levels_wait_for_memory(make, monkeypatch):
    most = {"at once": 0}
    jobs = make('{"coarse": {"sleep": 0.3}, "fine": {"sleep": 0.3}, "base": {"sleep": 0.3}}', processes=3)
    popen = module.subprocess.Popen
    started: list = []

    def watched(*args, **kwargs):
        started.append(popen(*args, **kwargs))
        most["at once"] = max(most["at once"], sum(process.poll() is None for process in started))
        return started[-1]

    monkeypatch.setattr(module.subprocess, "Popen", watched)
    monkeypatch.setattr(module, "expected_memory_mb", lambda scene: 1e12)
    jobs.run([base_level(), COARSE, FINE])
    assert len(started) == 3
    assert most["at once"] == 1


def test_nothing_is_started_once_the_scene_itself_fails(make, tmp_path):
    jobs = make('{"base": {"code": 4, "state": "failed"}}')
    jobs.run([base_level(), COARSE])
    assert order(tmp_path) == ["base"]
    assert jobs.outcomes["coarse"] == Outcome("left out", "the scene itself fails")


def test_what_is_done_is_kept_and_the_rest_goes_on(make, tmp_path):
    first = make('{"coarse": {"code": 75, "state": "stopped"}}')
    write_run(first.run_of(base_level()), scene_of(base_level()))
    first.run([base_level(), COARSE])
    assert order(tmp_path) == ["coarse"]
    assert first.outcomes["coarse"].state == "stopped"
    again = make()
    again.run([base_level(), COARSE])
    assert order(tmp_path) == ["coarse", "coarse"]
    assert again.outcomes["coarse"].state == "done"


def test_run_of_another_scene_is_not_taken(make):
    jobs = make()
    write_run(jobs.run_of(COARSE), scene_of(base_level()))
    with pytest.raises(InputError, match="another scene"):
        jobs.run([COARSE])
    threads = load_scene("overhand", [*FINE.overrides, "solver.threads=2"])
    write_run(jobs.run_of(FINE), threads)
    jobs.run([FINE])


def test_asked_to_stop_ends_the_processes(make, tmp_path, monkeypatch):
    jobs = make('{"base": {"sleep": 60}, "coarse": {"sleep": 60}}', processes=2)
    monkeypatch.setattr(StopRequest, "due", property(lambda self: len(order(tmp_path)) == 2))
    began = module.time.monotonic()
    with pytest.raises(Stopped, match="the same command goes on"):
        jobs.run([base_level(), COARSE])
    assert module.time.monotonic() - began < 30.0
    assert sorted(order(tmp_path)) == ["base", "coarse"]
