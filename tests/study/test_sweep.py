"""A study with an engine that computes nothing: the table, what is kept, what fails, what is refused."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from manufactured import TRUE_FORCE, error_of, write_run
from stand_in import StandIn

import knotfem as kf
from knotfem.errors import InputError, KnotfemError, MissingDependency, NotConverged, SeveralErrors, Stopped
from knotfem.run.tables import read_table
from knotfem.shipped import scene_path
from knotfem.study.engine.engine import Job
from knotfem.study.engine.outcomes import CRASHED, Outcome
from knotfem.study.sweep import points as module
from knotfem_cli.main import knotfem_command

STUDY: dict[str, Any] = {
    "name": "friction",
    "scene": "overhand",
    "axes": [
        {"key": "contact.friction", "linspace": [0.1, 0.3, 3]},
        {"key": "rods.0.mesh.element_length", "values": ["2 mm", "3 mm"]},
    ],
    "set": {"steps.pull.displacement": "30 mm"},
    "collect": {
        "end": {"table": "force", "column": "force_N"},
        "half": {"table": "force", "column": "force_N", "at": "15 mm"},
        "middle": {"table": "tension", "column": "tension_N", "s_over_L": 0.5},
        "most": {"table": "tension", "column": "tension_N"},
        "steps": "steps",
        "cpu": "phases.pull.cpu_s",
        "knot": "knot_after",
    },
}


def write_results(job: Job) -> Outcome:
    """The results of a run, which fails with much friction."""
    scene = job.run.scene
    if scene.contact.friction > 0.25:
        return Outcome("failed", "strands passed through each other", 5)
    (job.run.path / "scene.toml").unlink()
    write_run(job.run, scene)
    summary = job.run.read_summary() | {"knot_after": "3_1", "verdict": "holds", "failure_mode": None}
    job.run.write_summary(summary)
    return Outcome("done")


@pytest.fixture
def engines(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[StandIn]:
    """Engines that were used, oldest first; each writes results."""
    used: list[StandIn] = []

    def engine(*arguments: object, **others: object) -> StandIn:
        (tmp_path / "out").mkdir(exist_ok=True)
        used.append(StandIn(write_results))
        return used[-1]

    monkeypatch.setattr(module, "Engine", engine)
    monkeypatch.chdir(tmp_path)
    return used


def sweep(study: dict[str, Any] | str | Path = STUDY, out: str | None = "out", **options: Any) -> kf.StudyTable:
    return kf.sweep(study, out=out, progress=False, **options)


def test_table_has_a_row_for_each_point(engines: list[StandIn]) -> None:
    table = sweep()
    assert list(table.columns) == [
        "point", "contact.friction", "rods.0.mesh.element_length", "state", "verdict", "failure_mode", "reason",
        *STUDY["collect"],
    ]  # fmt: skip
    assert table["contact.friction"].tolist() == [0.1, 0.1, 0.2, 0.2, 0.3, 0.3]
    assert table["rods.0.mesh.element_length"].tolist() == ["2 mm", "3 mm"] * 3
    assert table["state"].tolist() == ["done"] * 4 + ["failed"] * 2
    assert table["reason"].tolist() == [""] * 4 + ["strands passed through each other"] * 2
    assert table["verdict"].tolist() == ["holds"] * 4 + [""] * 2
    forces = [TRUE_FORCE * (1.0 + error_of(table.run(i).scene)) for i in range(4)]
    assert table["end"][:4] == pytest.approx(forces)
    assert table["half"][:4] == pytest.approx([0.5 * force for force in forces])
    assert table["middle"][:4] == pytest.approx([0.5 * force for force in forces])
    assert table["most"][:4] == pytest.approx(forces)
    assert np.isnan(table["end"][4:]).all()
    assert table["cpu"][0] == table.run("friction=0.1_element_length=2mm").summary["phases"]["pull"]["cpu_s"]
    assert table["knot"].tolist() == ["3_1"] * 4 + [""] * 2
    assert repr(table) == "<study 'out', 6 points: 4 done, 2 failed>"
    with pytest.raises(InputError, match='"steps"'):
        table["step"]


def test_what_is_on_disk(engines: list[StandIn]) -> None:
    table = sweep()
    written = read_table(Path("out/study.csv"))
    assert {name: column.tolist() for name, column in written.items() if name != "end"} == {
        name: column.tolist() for name, column in table.columns.items() if name != "end"
    } or "nan" in str(written)
    status = json.loads(Path("out/study.json").read_text())
    assert (status["state"], status["points"], status["done"], status["failed"]) == ("done", 6, 4, 2)
    assert status["runs"]["friction=0.1_element_length=2mm"]["worker"] == "stand-in"
    assert "wall" not in Path("out/study.csv").read_text()
    assert sorted(path.name for path in Path("out/runs").iterdir()) == sorted(table.points)
    threads = table.run(0).scene.solver.threads
    assert threads == 1, "results must not depend on the worker"


def test_parquet_where_pyarrow_is_installed(engines: list[StandIn], monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = sweep()
    read = parquet.read_table("out/study.parquet").to_pydict()
    assert list(read) == list(table.columns)
    assert read["steps"][:4] == table["steps"][:4].tolist()
    Path("out/study.parquet").unlink()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    sweep()
    assert not Path("out/study.parquet").exists()


def test_pandas_or_a_message(engines: list[StandIn], monkeypatch: pytest.MonkeyPatch) -> None:
    table = sweep()
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingDependency, match="pip install pandas"):
        table.to_pandas()


def test_what_is_known_is_kept_and_new_points_are_run(engines: list[StandIn]) -> None:
    first = sweep()
    text = Path("out/study.csv").read_bytes()
    assert len(engines[0].order) == 6
    sweep()
    assert engines[1].order == [], "a failure is a result"
    assert Path("out/study.csv").read_bytes() == text
    again = sweep("out", out=None)
    assert Path("out/study.csv").read_bytes() == text, "the folder stands for the study"
    assert (again.path, engines[2].order) == (Path("out"), [])
    more = {**STUDY, "axes": [{"key": "contact.friction", "values": [0.1, 0.15]}, STUDY["axes"][1]]}
    assert len(sweep(more)) == 4
    assert engines[3].order == ["friction=0.15_element_length=2mm", "friction=0.15_element_length=3mm"]
    with pytest.raises(InputError, match="another scene"):
        sweep({**STUDY, "set": {"steps.pull.displacement": "20 mm"}})
    assert first.run(0).scene.contact.friction == 0.1


def test_point_that_is_no_scene_has_failed(engines: list[StandIn]) -> None:
    lengths = {"key": "rods.0.mesh.element_length", "values": ["2 mm", "400 mm"]}
    table = sweep({**STUDY, "axes": [lengths], "set": {"contact.friction": 0.2}})
    assert table["state"].tolist() == ["done", "failed"]
    assert table["reason"][1].startswith("rods.0.mesh.element_length: too long for the rod")
    assert engines[0].order == ["element_length=2mm"]


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"axes": [{"key": "contact.fiction", "values": [0.1]}]}, "contact.fiction: unknown key; expected"),
        ({"axes": [{"key": "rods.2.length", "values": ["1 mm"]}]}, "rods.2: no such entry"),
        ({"set": {"steps.push.displacement": "1 mm"}}, "steps.push: no such entry"),
        ({"axes": [{"key": "contact.friction", "values": [-1.0, "firm"]}]}, "contact.friction: wrong value"),
        ({"scene": "overhnad"}, '"overhand"'),
        ({"axes": [{"key": "scene", "values": ["overhand", "knot.toml"]}], "scene": None, "set": {}}, "knot.toml"),
    ],
)
def test_study_whose_keys_are_wrong_is_refused(
    engines: list[StandIn], changed: dict[str, Any], problem: str, tmp_path: Path
) -> None:
    tables = {name: value for name, value in {**STUDY, **changed}.items() if value is not None}
    with pytest.raises(SeveralErrors) as caught:
        sweep(tables)
    assert problem in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_paths_start_at_the_file_of_the_study(engines: list[StandIn], tmp_path: Path) -> None:
    away = tmp_path / "away"
    away.mkdir()
    (away / "mine.toml").write_text(scene_path("overhand").read_text())
    (away / "study.toml").write_text(
        'axes = [{ key = "scene", values = ["mine.toml", "overhand"] }]\nset.contact.friction = 0.2\n'
    )
    table = sweep(away / "study.toml")
    assert table["scene"].tolist() == ["mine.toml", "overhand"]
    assert table.points == ["scene=mine", "scene=overhand"]
    assert [table.run(i).scene.name for i in range(2)] == ["mine", "overhand"]
    text = Path("out/study.csv").read_bytes()
    sweep("out", out=None)
    assert Path("out/study.csv").read_bytes() == text


def test_default_folder_is_named_like_the_study(engines: list[StandIn]) -> None:
    Path("studies/friction").mkdir(parents=True)
    assert sweep(out=None).path == Path("studies/friction")
    Path("file").write_text("")
    with pytest.raises(InputError, match="this is a file"):
        sweep(out="file")


def test_how_a_study_ends(engines: list[StandIn], monkeypatch: pytest.MonkeyPatch) -> None:
    def ends(act: Callable[[Job], Outcome], error: type[KnotfemError], text: str, out: str) -> None:
        Path(out).mkdir()
        monkeypatch.setattr(module, "Engine", lambda *a, **o: StandIn(act))
        with pytest.raises(error, match=text):
            sweep(out=out)
        assert Path(out, "study.csv").exists()

    ends(lambda job: Outcome("failed", "no rest", 4), NotConverged, "no point could be computed.*no rest", "none")
    ends(
        lambda job: write_results(job) if "2mm" in job.name else Outcome("failed", "crashed", CRASHED),
        KnotfemError, "3 points crashed.*the same command tries again", "crash",
    )  # fmt: skip

    def stop(job: Job) -> Outcome:
        if "0.2" in job.name:
            raise Stopped("stopped")
        return write_results(job)

    ends(stop, Stopped, "stopped", "stop")
    states = read_table(Path("stop/study.csv"))["state"].tolist()
    assert states == ["done", "done", "waiting", "waiting", "waiting", "waiting"]
    assert json.loads(Path("stop/study.json").read_text())["state"] == "stopped"


def test_knots_of_several_rods_are_in_words_in_the_table() -> None:
    from knotfem.run.knot_words import knot_said_in_one

    knots = {rod: {"said": "unknot", "laced": {other: ["t"]}} for rod, other in (("a", "b"), ("b", "a"))}
    assert knot_said_in_one(knots) == "a: unknot, linked with b; b: unknot, linked with a"
    assert knot_said_in_one("3_1") == "3_1"


def friction_values(*values: object) -> dict[str, Any]:
    return {"scene": "overhand", "axes": [{"key": "contact.friction", "values": list(values)}]}


@pytest.mark.parametrize(
    "study",
    [
        friction_values(0.1, 0.2, 0.1),
        {"scene": "overhand", "axes": [{"key": "rods.0.length", "values": ["480 mm", "0.48 m"]}]},
        {"scene": "overhand", "axes": [{"key": "contact.friction", "linspace": [0.2, 0.2, 3]}]},
    ],
)
def test_equal_points_are_refused_not_counted_twice(engines: list[StandIn], study: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"axes: two points are the same scene; found .* and .*; expected each once"):
        sweep(study)
    assert not engines


def test_a_rope_is_for_all_points_and_goes_on(engines: list[StandIn]) -> None:
    rope = {"diameter": "10 mm", "friction": 0.25}
    study = {"scene": "overhand", "axes": [{"key": "rods.0.mesh.element_length", "values": ["4 mm", "5 mm"]}]}
    table = sweep({**study, "rope": rope})
    scenes = [table.run(point).scene for point in range(2)]
    assert [(scene.diameter, scene.contact.friction) for scene in scenes] == [(10.0, 0.25)] * 2
    assert [scene.rods[0].mesh.element_length for scene in scenes] == [4.0, 5.0]
    again = kf.sweep("out", progress=False)
    assert len(engines[-1].order) == 0
    assert again.points == table.points
    with pytest.raises(InputError, match="rope: diameter: a bare number"):
        sweep(study, "other", rope={"diameter": 10})
    Path("other").mkdir()
    given = sweep(study, "other", rope=rope)
    assert given.run(0).scene.rope == scenes[0].rope


def test_rope_of_the_command(engines: list[StandIn]) -> None:
    Path("s.toml").write_text('scene = "capstan"\n[[axes]]\nkey = "contact.friction"\nvalues = [0.1, 0.2]\n')
    dry = call("sweep", "s.toml", "--rope", "diameter=10 mm", "friction=0.2", "--dry-run")
    assert dry.exit_code == 0, dry.output
    assert "rope: capstan of 6 mm" in dry.stderr
    assert "friction on obstacles as it was (obstacle_friction changes it)" in dry.stderr
    both = call("sweep", "s.toml", "--rope", "friction=0.2", "obstacle_friction=0.2", "--dry-run")
    assert "friction on obstacles" not in both.stderr


def call(*arguments: object) -> Any:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


def test_command(engines: list[StandIn], tmp_path: Path) -> None:
    Path("s.toml").write_text('scene = "overhand"\n[[axes]]\nkey = "contact.friction"\nvalues = [0.1, 0.3]\n')
    dry = call("sweep", "s.toml", "--set", "steps.pull.displacement=30 mm", "--dry-run", "--jobs", "2")
    assert dry.exit_code == 0, dry.output
    assert "runs at a time 2" in " ".join(dry.stdout.split())
    assert not (tmp_path / "studies").exists()
    Path("studies/s").mkdir(parents=True)
    found = call("sweep", "s.toml", "--set", "steps.pull.displacement=30 mm", "--log-format", "json")
    assert found.exit_code == 0, found.output
    told = json.loads(found.stdout)
    assert told["folder"] == "studies/s"
    assert told["points"]["state"] == ["done", "failed"]
    assert json.loads(found.stderr.splitlines()[-1])["done"] == 1
    known = call("sweep", "studies/s", "--dry-run", "--log-format", "json")
    assert (json.loads(known.stdout)["runs"], json.loads(known.stdout)["known already"]) == (0, 2)
    quiet = call("sweep", "studies/s", "--quiet")
    assert (quiet.stdout, quiet.stderr) == ("studies/s\n", "")
    Path("wrong.toml").write_text('scene = "overhand"\n[[axes]]\nkey = "contact.fiction"\nvalues = [0.1]\n[sets]\n')
    wrong = call("sweep", "wrong.toml")
    assert (wrong.exit_code, wrong.stdout) == (3, "")
    assert wrong.stderr.startswith("knotfem: wrong.toml: sets: unknown key")
    both = call("sweep", "s.toml", "--scheduler", "tcp://a:1", "--jobs", "2")
    assert (both.exit_code, "--jobs, --scheduler: more than one place" in both.stderr) == (3, True)
