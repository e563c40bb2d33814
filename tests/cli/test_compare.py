"""The verb that holds runs against each other, and the options that name a model or a run to set out from."""

import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result
from stored_runs import pulled

import knotfem.api
from knotfem.results.compare import Cell, Figure
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.scene import load_scene
from knotfem_cli.main import knotfem_command


def call(*arguments: object) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    RunDirectory.create(load_scene("overhand"), Path("solid"))
    RunDirectory.create(load_scene("overhand", ["model=rod"]), Path("light"))
    return tmp_path


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What the library was asked to compare."""
    made: list[Any] = []

    def compare(*runs: Run, locking: float | None, at: float | None, step: str | None) -> SimpleNamespace:
        made.append(([str(run.path) for run in runs], locking, at, step))
        figures = [
            Figure("force there", "N", [1.5, 2.0]),
            Figure("force there, difference", "share", [None, 0.25]),
            Figure("model", "", ["fem", "rod"]),
        ]
        labels = [SimpleNamespace(label=run.name) for run in runs]
        return SimpleNamespace(curves=labels, figures=figures, write=lambda out: out.with_suffix(".csv"))

    module = ModuleType("knotfem.results.compare")
    vars(module).update(compare=compare, RELATIVE="share", Figure=Figure, Cell=Cell)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return made


def test_compare_prints_the_differences_and_where_they_are(folder: Path, asked: list[Any]) -> None:
    result = call("compare", "solid", "light", "--at", "6 cm", "--locking", "50 mm")
    assert asked == [(["solid", "light"], 50.0, 60.0, None)]
    assert result.stdout == "compare.png\ncompare.csv\n"
    assert "25.00 %" in result.stderr
    assert "force there [N]" in result.stderr
    assert call("compare", "solid", "light", "-o", "a.pdf", "--quiet").output == "a.pdf\na.csv\n"
    assert call("compare", "solid", "light", "--step", "load").exit_code == 0
    assert asked[-1] == (["solid", "light"], None, None, "load")


def test_compare_as_json(folder: Path, asked: list[Any]) -> None:
    found = json.loads(call("compare", "solid", "light", "--log-format", "json").stdout)
    assert found["figures"]["force there"] == {"unit": "N", "solid": 1.5, "light": 2.0}
    assert found["figures"]["force there, difference"]["solid"] is None


def test_compare_needs_runs(folder: Path) -> None:
    assert call("compare").exit_code == 2
    assert call("compare", "solid", "none").exit_code == 3
    result = call("compare", "solid", "light")
    assert result.exit_code == 3
    assert "no loading step is stored" in result.stderr


@pytest.mark.parametrize("verb", ["tension", "render", "resume"])
def test_model_of_a_run_is_what_it_is(folder: Path, verb: str) -> None:
    result = call(verb, "solid", "--model", "rod")
    assert result.exit_code == 3
    assert "--set: model: cannot change in a run" in result.stderr


def test_set_out_from_another_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes, known = [], []
    monkeypatch.setattr(knotfem.api, "source_rods", lambda scene: known.append(scene.tie.source_state))
    monkeypatch.setattr(knotfem.api, "drive", lambda run, *arguments, **options: scenes.append(run.scene))
    assert call("tie", "overhand", "--model", "rod", "--from", "solid", "-o", "new").exit_code == 0
    assert scenes[0].tie.source == str(folder / "solid")
    assert load_scene("new/scene.toml") == scenes[0]
    assert call("pull", "overhand", "--model", "rod", "--from", "solid", "--last", "-o", "on").exit_code == 0
    assert known == ["tied", "last"]
    result = call("tie", "overhand", "--model", "rod", "--from", "solid", "-o", "solid", "--force")
    assert "solid: the run would replace its source" in result.stderr
    assert RunDirectory.is_run("solid")
    result = call("tie", "overhand", "--from", "solid", "-o", "other")
    assert result.exit_code == 3
    assert "only the rod model sets out from another run" in result.stderr


@pytest.mark.parametrize("verb", ["tie", "pull"])
def test_nothing_is_made_where_the_source_is_wrong(folder: Path, verb: str) -> None:
    result = call(verb, "overhand", "--model", "rod", "--from", "nope", "-o", "other")
    assert result.exit_code == 3
    assert "nope: no such run" in result.stderr
    result = call(verb, "overhand", "--model", "rod", "--from", "solid", "-o", "other")
    assert "solid: not tied yet" in result.stderr
    assert not (folder / "other").exists()


def test_check_looks_at_the_source(folder: Path) -> None:
    result = call("check", "overhand", "--model", "rod", "--from", "light", "--quiet")
    assert result.exit_code == 3
    assert "light: model: the source is a rod run" in result.stderr


def test_plot_draws_one_run_or_several(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    pulled(Path("solid"))
    pulled(Path("light"), 1.1)
    assert call("plot", "solid").stdout == "plot.png\n"
    asked = ("--quantity", "tension", "--at", "31 mm", "--label", "fine", "--label", "coarse", "-o", "a.svg")
    result = call("plot", "solid", "light", *asked)
    assert result.stdout == "a.svg\n"
    assert "fine, the nearest stored state: 30 mm" in result.stderr
    assert all(f">{label}<" in Path("a.svg").read_text() for label in ("fine", "coarse"))
    states = json.loads(call("plot", "solid", *asked[:4], "--log-format", "json").stdout)["states"]
    assert states["solid"]["displacement_mm"] == 30.0
    assert call("plot", "solid", "--xlim", ":9", "--ylim", "0:", "--width", "85 mm", "--quiet").exit_code == 0
    for wrong, said in (
        (("--xlim", "9"), '--xlim: no limits; found "9"'),
        (("--width", "85"), "--width: a bare number, its unit is missing"),
        (("--force-unit", "kN"), "Invalid value for '--force-unit'"),
        (("--label", "a", "--label", "b"), "--label: labels do not fit"),
    ):
        result = call("plot", "solid", *wrong)
        assert result.exit_code in (2, 3)
        assert said in result.stderr
    assert "knotfem plot draws a single one" in call("compare", "solid").stderr
