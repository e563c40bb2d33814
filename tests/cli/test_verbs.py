"""The verbs call the library with what the user typed and print where the results are."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import knotfem.api
import knotfem.results
import knotfem.run
from knotfem import errors, shipped
from knotfem.models.base import Additions
from knotfem.results.fields import StateFields
from knotfem.results.figures import RunFigures
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.tables import write_table
from knotfem.run.vtkhdf import VtkHdfSeries
from knotfem.scene import Scene, load_scene
from knotfem_cli.main import knotfem_command

Calls = list[tuple[Any, ...]]


def call(*arguments: object) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Puts functions into the place of a module of the library."""

    def replace(package: ModuleType, name: str, **functions: Callable[..., object]) -> None:
        module = ModuleType(f"{package.__name__}.{name}")
        vars(module).update(functions)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(package, name, module, raising=False)

    return replace


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Calls:
    """What was to be computed: goal, scene and run directory; works in an empty folder."""
    monkeypatch.chdir(tmp_path)
    made: Calls = []

    def drive(run: RunDirectory, goal: str, progress: object, **options: object) -> None:
        assert isinstance(options["figures"], RunFigures)
        assert isinstance(options["additions"], Additions)
        assert options["additions"].empty
        made.append((goal, run.scene, run))
        if goal == "tie":
            run.write_status("done", goal=goal)
            run.checkpoints.save({"simulation": {}, "summary": {}}, {"goal": goal, "rows": {}}, name=TIED)
            run.write_summary({"steps": 7, "phases": {"mapping": {"wall_s": 1.5}}})

    monkeypatch.setattr(knotfem.api, "drive", drive)
    return made


def test_scenes() -> None:
    text = call("scenes").stdout
    assert all(name in text for name in [*shipped.scene_names(), *shipped.centreline_names()])
    assert call("scenes", "--quiet").stdout.split() == shipped.scene_names()
    assert "bowline" in json.loads(call("scenes", "--log-format", "json").stdout)["scenes"]
    assert call("scenes", "--quiet", "--set", "rods.1.length=40 mm").stdout.split() == [
        "crossed-rods",
        "hard/soft-crossing",
        "sheet-bend",
    ]
    assert call("scenes", "--set", "nonsense").exit_code == 3


def test_tie(calls: Calls) -> None:
    result = call("tie", "bowline", "--path", "linear", "--model", "rod", "--set", "contact.friction=0.2")
    assert result.exit_code == 0
    ((verb, scene, run),) = calls
    assert (verb, scene.tie.path, scene.model, scene.contact.friction) == ("tie", "linear", "rod", 0.2)
    assert result.stdout == "runs/bowline-1\n"
    assert run.path == Path("runs/bowline-1")
    assert load_scene(run.scene_file) == scene
    assert "run directory runs/bowline-1" in result.stderr
    assert "mapping  1.5 s" in result.stderr


@pytest.mark.parametrize("key", ["centerline", "centreline"])
def test_a_centreline_in_either_spelling(calls: Calls, key: str) -> None:
    assert (
        call("tie", "overhand", "--set", f"rods.0.{key}=figure_eight", "--set", "rods.0.length=528 mm").exit_code == 0
    )
    assert calls[0][1].rods[0].centerline == "figure_eight"


def test_quiet_and_json(calls: Calls) -> None:
    assert call("tie", "bowline", "-o", "a", "--quiet").output == "a\n"
    result = call("tie", "bowline", "-o", "b", "--log-format", "json")
    assert json.loads(result.stdout) == {"run": "b", "steps": 7, "phases": {"mapping": {"wall_s": 1.5}}}
    assert [json.loads(line) for line in result.stderr.splitlines()] == [{"message": "run directory b"}]


def test_runs_are_not_overwritten(calls: Calls) -> None:
    assert call("tie", "bowline", "-o", "a").exit_code == 0
    result = call("tie", "bowline", "-o", "a")
    assert result.exit_code == 3
    assert "holds a run already" in result.stderr
    assert call("tie", "overhand", "-o", "a", "--force").exit_code == 0
    assert load_scene("a/scene.toml").name == "overhand"
    assert len(calls) == 2


def test_pull_a_scene(calls: Calls) -> None:
    assert call("pull", "bowline", "-o", "a").exit_code == 0
    assert [(verb, run.path) for verb, _, run in calls] == [("pull", Path("a"))]


def test_the_verdict_is_told_in_words(calls: Calls, monkeypatch: pytest.MonkeyPatch) -> None:
    said = "the knot holds: it came to rest under the load after 0.1 diameters of rod had run through it"
    drive = knotfem.api.drive

    def judge(run: RunDirectory, *arguments: Any, **options: Any) -> None:
        drive(run, *arguments, **options)
        run.write_summary({"verdict": "holds", "verdict_evidence": {"in_words": said}, "failure_mode": "none"})

    monkeypatch.setattr(knotfem.api, "drive", judge)
    assert said in " ".join(call("pull", "bowline").stderr.split())
    assert "the knot holds" not in call("pull", "bowline", "--quiet", "-o", "other").stderr


def test_knots_of_two_rods_are_told_in_words(calls: Calls, monkeypatch: pytest.MonkeyPatch) -> None:
    def drive(run: RunDirectory, goal: str, progress: object, **options: object) -> None:
        record = {"name": "unknot", "closures": {"unknot": 12}, "linking": [], "turns": []}
        knots = {"hitch": {**record, "said": "unknot", "laced": {"bight": ["t"]}},
                 "bight": {**record, "said": "3_1 (by 10 of 12 closures)", "laced": {"hitch": []}}}  # fmt: skip
        run.write_summary({"steps": 7, "knot_before": knots, "knot_after": knots})

    monkeypatch.setattr(knotfem.api, "drive", drive)
    result = call("pull", "sheet-bend", "-o", "run")
    assert result.exit_code == 0, result.output
    assert "knot after\n  hitch  unknot, linked with bight\n  bight  3_1 (by 10 of 12 closures)\n" in result.stderr
    assert "linking" not in result.stderr
    assert "closures" in knotfem.open_run("run").summary["knot_after"]["hitch"], "the summary keeps the record"
    assert knotfem.open_run("run").knot == {
        "hitch": "unknot, linked with bight", "bight": "3_1 (by 10 of 12 closures)"
    }  # fmt: skip


def test_a_folder_that_is_no_run_does_not_hide_a_shipped_scene(calls: Calls) -> None:
    Path("bowline/runs").mkdir(parents=True)
    assert call("pull", "bowline", "-o", "out").exit_code == 0
    assert [(verb, scene.name, run.path) for verb, scene, run in calls] == [("pull", "bowline", Path("out"))]
    Path("mine").mkdir()
    refused = call("pull", "mine")
    assert refused.exit_code == 3
    assert "no run is in this folder" in refused.stderr


def test_a_run_that_hides_a_shipped_scene_is_told(calls: Calls, caplog: pytest.LogCaptureFixture) -> None:
    call("tie", "bowline", "-o", "bowline")
    assert "not the shipped scene" not in call("pull", "./bowline", "-o", "a").stderr
    told = call("pull", "bowline", "-o", "out")
    assert told.exit_code == 0
    assert told.stderr.count("bowline: the run directory bowline, not the shipped scene of this name; ") == 1
    assert not caplog.records
    knotfem.open_run("bowline")
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert "not the shipped scene" in caplog.text


def test_pull_a_run_in_its_place(calls: Calls) -> None:
    call("tie", "bowline", "-o", "a")
    assert call("pull", "a", "--set", "solver.threads=1").exit_code == 0
    verb, scene, run = calls[-1]
    assert (verb, run.path, scene.solver.threads) == ("pull", Path("a"), 1)
    result = call("pull", "a", "--set", "contact.friction=0.37")
    assert result.exit_code == 3
    assert "cannot change in a run" in result.stderr
    assert call("pull", "a", "--model", "rod").exit_code == 3


def test_pull_does_not_replace_its_source(calls: Calls) -> None:
    call("tie", "bowline", "-o", "bowline")
    kept = sorted(Path("bowline").iterdir())
    result = call("pull", "bowline", "-o", "bowline", "--force")
    assert result.exit_code == 3
    assert "the run would replace its source" in result.stderr
    assert sorted(Path("bowline").iterdir()) == kept


def test_pull_a_run_elsewhere(calls: Calls) -> None:
    call("tie", "bowline", "-o", "a")
    assert call("pull", "a", "-o", "b", "--set", "contact.friction=0.37").exit_code == 0
    verb, scene, run = calls[-1]
    assert (verb, run.path, scene.contact.friction) == ("pull", Path("b"), 0.37)
    assert run.tied
    assert load_scene("a/scene.toml").contact.friction == 0.33


def test_pull_elsewhere_a_run_that_is_not_tied(calls: Calls) -> None:
    RunDirectory.create(load_scene("bowline"), Path("a"))
    assert call("pull", "a", "-o", "b").exit_code == 0
    assert not calls[-1][2].tied


def test_resume(calls: Calls) -> None:
    call("tie", "bowline", "-o", "a")
    assert call("resume", "a", "--set", "solver.time_limit=1 h").exit_code == 0
    goal, scene, run = calls[-1]
    assert (goal, scene.solver.time_limit, run.path) == ("tie", 3600.0, Path("a"))


@pytest.mark.parametrize(
    ("kind", "code"), [("InputError", 3), ("NotConverged", 4), ("KnotLost", 5), ("Stopped", 75), ("Interrupted", 130)]
)
def test_errors_end_with_their_code(calls: Calls, monkeypatch: pytest.MonkeyPatch, kind: str, code: int) -> None:
    error = getattr(errors, kind)("it went wrong")

    def fail(*arguments: object, **options: object) -> None:
        raise error

    monkeypatch.setattr(knotfem.api, "drive", fail)
    result = call("tie", "bowline")
    assert (
        result.exit_code
        == error.exit_code
        == {"NotConverged": 4, "KnotLost": 5, "Stopped": 75, "Interrupted": 130, "InputError": 3}[kind]
    )
    assert result.stderr.endswith("knotfem: it went wrong\n")
    assert result.stdout == ""
    last = call("tie", "bowline", "--log-format", "json").stderr.splitlines()[-1]
    assert json.loads(last) == {"error": "it went wrong", "exit_code": error.exit_code}


def test_check(stand_in: Callable[..., None]) -> None:
    found = {"dofs": 12, "effects": {"gravity": "absent"}, "warnings": [], "time": 0.125, "knot": None}
    stand_in(knotfem.run, "check", check=lambda scene: found)
    result = call("check", "bowline", "--set", "contact.friction=0.2")
    assert result.exit_code == 0
    assert "\nfriction = 0.2\n" in result.stdout
    names, values = ("degrees of freedom", "warnings", "time", "knot"), ("12", "none", "0.125", "-")
    facts = "".join(f"{name:<18}  {value}\n" for name, value in zip(names, values, strict=True))
    assert f"\neffects that act\n  gravity  absent\n{facts}" in result.stdout
    found["warnings"] = ["the first, with a comma", "the second"]
    assert "\nwarnings\n  the first, with a comma\n  the second\n" in call("check", "bowline").stdout
    assert call("check", "bowline", "--quiet").output == ""
    assert json.loads(call("check", "bowline", "--log-format", "json").stdout)["dofs"] == 12
    assert call("check", "bowline", "--set", "contact.friction=-1").exit_code == 3
    named = call("check", "bowline", "--set", "steps.pull.displacement=20")
    assert named.stderr.startswith("knotfem: --set: steps.pull.displacement: ")


def stored_run(path: Path) -> Path:
    """A run with two stored states and their fields, of which the last is at 59 mm."""
    run = RunDirectory.create(load_scene("bowline"), path)
    arclength, force = np.array([0.0, 1.0, 2.0]), np.array([0.5, 0.25, 0.1])
    rows = {"displacement_mm": np.repeat([3.0, 59.0], 3), "time_s": np.repeat([1.0, 2.0], 3)}
    profiles = {"arclength_mm": arclength, "s_over_L": arclength / 2.0, "tension_N": force}
    write_table(path / "tension.csv", {**rows, **{name: np.tile(values, 2) for name, values in profiles.items()}})
    points = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    with VtkHdfSeries.create(path / "results.vtkhdf", points, np.arange(8)[None]) as series:
        for time in (1.0, 2.0):
            series.append(time, points + time)
    return run.path


def test_tension(tmp_path: Path) -> None:
    path = stored_run(tmp_path / "run")
    header = "displacement_mm,time_s,arclength_mm,s_over_L,tension_N\n"
    table = header + "59.0,2.0,0.0,0.0,0.5\n59.0,2.0,1.0,0.5,0.25\n59.0,2.0,2.0,1.0,0.1\n"
    result = call("tension", path)
    assert result.stdout == table
    assert "0.5000 N at the start, 0.1000 N at the end" in result.stderr
    out = tmp_path / "t.csv"
    result = call("tension", path, "-o", out, "--at", "5.5 cm")
    assert result.stdout == ""
    assert "the nearest stored state: 59 mm" in result.stderr
    assert out.read_text() == table
    assert call("tension", path, "--at", "3 mm", "--quiet").stdout == table.replace("59.0,2.0", "3.0,1.0")
    assert json.loads(call("tension", path, "--log-format", "json").stdout)["tension_N"] == [0.5, 0.25, 0.1]
    result = call("tension", path, "--at", "60")
    assert result.exit_code == 3
    assert "unit is missing" in result.stderr
    assert call("tension", path, "-o", tmp_path / "none" / "t.csv").exit_code == 3
    result = call("tension", path, "-o", path / "force.csv")
    assert (result.exit_code, "the run's own file" in result.stderr) == (3, True)


def test_render(stand_in: Callable[..., None], tmp_path: Path) -> None:
    drawn: Calls = []
    framing: list[dict[str, object]] = []

    def draw(fields: StateFields, scene: Scene, out: Path, colour: str, **framed: object) -> None:
        drawn.append((out, colour, float(fields.points[0, 0])))
        framing.append(framed)

    stand_in(knotfem.results, "pictures", draw=draw)
    path = stored_run(tmp_path / "run")
    assert call("render", path).stdout == f"{path}/knot-strain.png\n"
    assert call("render", path, "-o", "a.png", "--colour", "tension", "--at", "3 mm").stdout == "a.png\n"
    assert drawn == [(path / "knot-strain.png", "strain", 2.0), (Path("a.png"), "tension", 1.0)]
    assert framing == [{"focus": "all", "zoom": 1.0, "view": None}] * 2
    call("render", path, "-o", "a.png", "--color", "tension", "--focus", "knot", "--zoom", "2")
    assert (drawn[-1][1], framing[-1]) == ("tension", {"focus": "knot", "zoom": 2.0, "view": None})
    assert call("render", path, "--colour", "red").exit_code == 2
    beyond = call("render", path, "--at", "99 mm")
    assert (beyond.exit_code, "no state is stored near this displacement" in beyond.stderr) == (3, True)
    (path / "results.vtkhdf").unlink()
    bare = call("render", path)
    assert (bare.exit_code, "no state was stored before the run ended" in bare.stderr) == (3, True)
    scene = path / "scene.toml"
    scene.write_text(scene.read_text().replace("fields = true", "fields = false"))
    assert "expected a run with output.fields = true" in call("render", path).stderr


def test_doctor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("knotfem.doctor.describe", lambda: {"threads": {"usable": 2}})
    assert call("doctor").stdout == "threads\n  usable  2\n"
    assert json.loads(call("doctor", "--log-format", "json").stdout) == {"threads": {"usable": 2}}
    assert call("doctor", "--quiet").output == ""
    monkeypatch.setattr("knotfem.sparse.linear.available", lambda: ["superlu"])
    result = call("doctor", "--set", "solver.linear=pardiso")
    assert result.exit_code == 3
    assert "pip install mkl" in result.stderr
