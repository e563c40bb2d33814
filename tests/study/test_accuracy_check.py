"""Errors measured by finer settings: rounds until within the target, budget, what is kept; the engine is a stand-in."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from manufactured import TRUE_FORCE, error_of, write_run
from stand_in import StandIn

import knotfem as kf
from knotfem.errors import InputError, NotConverged
from knotfem.plot import plots
from knotfem.run.directory import RunDirectory
from knotfem.run.expected import Expected
from knotfem.scene import load_scene
from knotfem.scene.model import Scene
from knotfem.study import jobs
from knotfem.study.accuracy_check import run as module
from knotfem.study.accuracy_check import search
from knotfem.study.accuracy_check.choices import FACTORS, choices_of, finer_size, level_at
from knotfem.study.accuracy_check.estimate import Change, estimated_error, to_adopt
from knotfem.study.engine.engine import Job
from knotfem.study.engine.outcomes import Outcome
from knotfem_cli.main import knotfem_command

SECOND = "section-x0.655+slice-x0.5+step-x0.25+penalty-x0.5"
"""Run of the settings that are adopted for 2 % after the first round."""


class Engines:
    """Engines whose runs follow the law of `manufactured`; some may be told to end otherwise."""

    def __init__(self) -> None:
        self.order: list[str] = []
        self.plan: dict[str, Outcome] = {}

    def make(self, *arguments: Any, **settings: Any) -> StandIn:
        engine = StandIn(self._act)
        engine.order = self.order
        return engine

    def _act(self, job: Job) -> Outcome:
        assert job.scene is not None
        shutil.rmtree(job.run.path)
        outcome = self.plan.get(job.name, Outcome("done"))
        write_run(job.run, job.scene, state="done" if outcome.state == "done" else "failed")
        return outcome


@pytest.fixture(autouse=True)
def engines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Engines:
    found = Engines()
    monkeypatch.setattr(jobs, "Engine", found.make)
    monkeypatch.setattr(module, "stored", list)
    monkeypatch.chdir(tmp_path)
    return found


def check(target: str = "2%", **settings: Any) -> kf.CheckedAccuracy:
    return kf.check_accuracy("overhand", target, out="knot", progress=False, **settings)


def call(*arguments: str) -> Result:
    return CliRunner().invoke(knotfem_command, ["pull", "overhand", "-o", "knot", *arguments])


def test_choices_are_those_of_the_model() -> None:
    assert choices_of(load_scene("overhand"))[0] == "section"
    rods = choices_of(load_scene("overhand", {"model": "rod"}))
    assert "section" not in rods
    assert {"slice", "penalty", "stick", "rate"} <= set(rods)
    assert not {"penalty", "ramp", "sampling", "stick"} & set(choices_of(load_scene("cantilever")))
    assert max(FACTORS.values()) == 0.5


def test_sizes_are_refined_and_named() -> None:
    scene = load_scene("overhand")
    assert level_at(scene, {"slice": 1.0}).name == "base"
    section = finer_size(scene, "section", {})
    assert section is not None
    finer = level_at(scene, {"section": section, "slice": 0.25})
    assert finer.name == f"section-x{section:.3g}+slice-x0.25"
    mesh = load_scene("overhand", finer.overrides).rods[0].mesh
    assert (mesh.section_elements, mesh.element_length) == (28, 0.25 * scene.rods[0].mesh.element_length)
    assert finer_size(scene, "section", {"section": (12 / 108) ** 0.5}) is None


def test_error_is_the_sum_of_what_first_order_leaves() -> None:
    changes = [Change("a", "", "", 0.5, 0.01), Change("b", "", "", 0.1, 0.009)]
    assert estimated_error(changes) == pytest.approx(0.03)
    assert estimated_error([*changes, Change("c", "", "", 0.5)]) is None


def test_largest_gain_for_its_cost_is_adopted_first() -> None:
    dear = Change("dear", "", "", 0.5, 0.02, 10.0, 11.0)
    cheap = Change("cheap", "", "", 0.5, 0.01, 1.0, 1.1)
    assert [one.choice for one in to_adopt([dear, cheap], 0.05)] == ["cheap"]
    assert [one.choice for one in to_adopt([dear, cheap], 0.04)] == ["cheap", "dear"]
    assert to_adopt([dear, cheap], 0.06) == []


def test_goes_on_until_the_error_is_within_the_target(engines: Engines) -> None:
    found = check("2%")
    assert found.reached
    assert found.estimate is not None
    assert 0.0 < error_of(found.run.scene) < found.estimate <= 0.02
    assert error_of(load_scene("overhand")) > 0.02, "the scene as it is would not do"
    assert engines.order[0] == "base"
    assert not any(change.expected or change.missing for change in found.changes)
    assert len(engines.order) == len(set(engines.order))
    assert found.start.startswith("the scene as it is: nothing was measured for scenes of the class knot")
    assert check("50%").run.scene.rods[0].mesh == load_scene("overhand").rods[0].mesh


def test_same_call_runs_nothing_again(engines: Engines) -> None:
    first = check()
    engines.order.clear()
    again = check()
    assert engines.order == []
    assert (again.estimate, again.changes, again.cpu_s) == (first.estimate, first.changes, first.cpu_s)


def test_result_is_a_run_that_says_how_accurate_it_is() -> None:
    found = check()
    assert found.run.path is not None
    accuracy = kf.open_run("knot").scene.accuracy
    assert accuracy is not None
    assert (accuracy.wanted, accuracy.measured) == (0.02, found.estimate)
    assert (accuracy.quantity, accuracy.scene) == ("force", "overhand")
    block = json.loads(Path("knot/summary.json").read_text())["accuracy"]
    assert block["reached"]
    assert block["estimate"] == found.estimate
    assert [row["choice"] for row in block["changes"]] == choices_of(load_scene("overhand"))
    force = found.run.force.force
    assert block["band_N"] == pytest.approx(found.estimate * np.sqrt(np.mean(force**2)), rel=0.05)  # pyright: ignore
    assert sorted(path.name for path in Path().iterdir()) == ["knot", "knot-check"]


def test_band_is_drawn_around_the_force(monkeypatch: pytest.MonkeyPatch) -> None:
    found = check()
    assert found.run.force.band == found.run.summary["accuracy"]["band_N"]
    (band,) = found.run.force.plot().collections
    (box,) = band.get_paths()
    force = found.run.force
    assert box.get_extents().ymax == pytest.approx(force.force[-1] + force.band)
    drawn: list[Any] = []
    monkeypatch.setattr(plots, "plot_force", lambda *arguments, **settings: drawn.append((arguments[0], settings)))
    check()
    ((curves, settings),) = drawn
    assert list(curves) == ["knot"]
    assert settings["bands"] == {"knot": force.band}


def test_band_in_the_picture(tmp_path: Path) -> None:
    curve = {"displacement_mm": [0.0, 1.0], "force_N": [0.0, TRUE_FORCE]}
    plots.plot_force({"knot": curve}, tmp_path / "with.svg", radius=1.0, bands={"knot": 0.1})
    plots.plot_force({"knot": curve}, tmp_path / "without.svg", radius=1.0)
    assert "within 0.1 N" in (tmp_path / "with.svg").read_text()
    assert "within" not in (tmp_path / "without.svg").read_text()


def test_budget_that_ends_leaves_what_was_found(engines: Engines, monkeypatch: pytest.MonkeyPatch) -> None:
    fine = load_scene("overhand").rods[0].mesh.element_length

    def takes(scene: Scene) -> Expected:
        seconds = 1e6 if scene.rods[0].mesh.element_length < fine else 0.0
        return Expected(1000, seconds, seconds, 512.0)

    monkeypatch.setattr(jobs, "expected", takes)
    found = check(budget="1h")
    assert not found.reached
    assert found.estimate is None, "the error of the slices is not known"
    assert "slice (left out: needs about " in found.ended
    assert found.run.scene.accuracy is None
    assert found.run.force.band is None
    assert found.run.summary["accuracy"]["not_checked"].keys() == {"slice"}
    engines.order.clear()
    later = check()
    assert later.reached
    assert "base" not in engines.order
    assert engines.order[0] == "slice-x0.5"


def test_budget_that_ends_between_rounds_keeps_the_estimate(engines: Engines, monkeypatch: pytest.MonkeyPatch) -> None:
    engines.plan[SECOND] = Outcome("stopped", "time limit")
    found = check()
    assert not found.reached
    assert SECOND in engines.order
    assert found.estimate is not None
    assert found.estimate > 0.02
    assert "stopped, time limit" in found.ended
    assert found.run.scene.rods[0].mesh == load_scene("overhand").rods[0].mesh


def test_finer_run_that_fails_is_named(engines: Engines) -> None:
    engines.plan["tolerance-x0.1"] = Outcome("failed", "no convergence", 4)
    found = check("50%")
    assert found.ended == "not checked: tolerance (failed: no convergence)"


def test_rounds_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "ROUNDS", 1)
    found = check("0.1%")
    assert found.ended == "1 rounds of finer settings were not enough"
    assert found.estimate is not None


def test_scene_that_fails_ends_the_search(engines: Engines) -> None:
    engines.plan["base"] = Outcome("failed", "no convergence", 4)
    with pytest.raises(NotConverged, match="the scene itself fails"):
        check()
    assert not Path("knot").exists()


def test_other_runs_are_not_replaced(engines: Engines) -> None:
    RunDirectory.create(load_scene("overhand"), Path("knot"))
    with pytest.raises(InputError, match="holds a run already"):
        check()
    assert engines.order == []
    assert check(force=True).reached
    with pytest.raises(InputError, match="a run keeps its settings"):
        kf.check_accuracy("knot", "2%", progress=False)
    with pytest.raises(InputError, match="decides this"):
        check(overrides={"solver.move_over_diameter": 0.1})


def test_command_says_what_was_asked_for_and_measured() -> None:
    done = call("--accuracy", "2%", "--check")
    assert done.exit_code == 0, done.output
    assert Path(done.stdout.strip()) == Path("knot").resolve()
    assert "starts from the scene as it is" in done.stderr
    assert "round 1: error " in done.stderr
    assert "asked for 2.00% in the force, measured 1." in done.stderr.splitlines()[-1]
    told = json.loads(call("--accuracy", "2%", "--check", "--log-format", "json").stdout)
    assert told["accuracy"]["target"] == 0.02


def test_command_ends_with_code_4_where_the_target_is_not_reached(engines: Engines) -> None:
    engines.plan["tolerance-x0.1"] = Outcome("failed", "no convergence", 4)
    done = call("--accuracy", "2%", "--check")
    assert done.exit_code == 4
    assert Path(done.stdout.strip()) == Path("knot").resolve()
    assert "knotfem: asked for 2.00% in the force, the error is not known" in done.stderr
    assert "not within the target: not checked: tolerance" in done.stderr


@pytest.mark.parametrize(
    ("options", "text"), [(["--check"], "--check: no accuracy"), (["--budget", "1h"], "--budget: only with --check")]
)
def test_options_that_belong_together(options: list[str], text: str) -> None:
    done = call(*options)
    assert done.exit_code == 3
    assert text in done.stderr
