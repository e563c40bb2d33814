"""`knotfem cost` and `knotfem pull --accuracy` on runs whose results follow a known law."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from manufactured import write_run, write_series

import knotfem.api
from knotfem.scene import load_scene
from knotfem.study.convergence import make_jobs
from knotfem.study.records import stored
from knotfem.study.refinement import Level, base_level
from knotfem_cli.main import knotfem_command

PULL = "steps.1.displacement=30 mm"
SERIES = ("section", "slice", "uniform")


def call(*arguments: object) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def measured(tmp_path: Path) -> Result:
    write_series(tmp_path / "costs" / "overhand", (PULL,), SERIES)
    chosen = [text for name in SERIES for text in ("--series", name)]
    return call("cost", "overhand", "--set", PULL, *chosen, "--store", tmp_path / "kept.json")


def test_cost_prints_table_and_recommendation_and_stores_it(measured, tmp_path):
    assert measured.exit_code == 0, measured.output
    assert "base: done already" in measured.stderr
    assert "5% in the force: " in measured.stdout
    assert measured.stdout.splitlines()[-1] == "costs/overhand"
    assert {path.name for path in (tmp_path / "costs" / "overhand").iterdir()} == {
        "runs", "cost.csv", "cost.png", "recommendation.json",
    }  # fmt: skip
    (record,) = json.loads((tmp_path / "kept.json").read_text())["measured"]
    assert (record["scene"], record["model"]) == ("overhand", "fem")
    assert "stored for --accuracy in " in measured.stderr
    chosen = [text for name in SERIES for text in ("--series", name)]
    again = call("cost", "overhand", "--set", PULL, *chosen, "--store", tmp_path / "kept.json")
    assert again.stderr.splitlines()[-1].endswith(f"in place of what was measured on overhand on {record['date']}")
    assert "overhand" not in [entry.scene for entry in stored() if entry.window == pytest.approx(5.0)]


def test_accuracy_takes_what_cost_stored(measured, tmp_path, monkeypatch):
    (tmp_path / "data" / "knotfem").mkdir(parents=True)
    (tmp_path / "kept.json").rename(tmp_path / "data" / "knotfem" / "recommendations.json")
    pulled = []

    def drive(run, goal, progress, **options) -> None:
        pulled.append((run.scene, run))

    monkeypatch.setattr(knotfem.api, "drive", drive)
    result = call(
        "pull", "overhand", "--accuracy", "5%", "--model", "fem", "--set", "contact.friction=0.2", "-o", "out"
    )
    assert result.exit_code == 0, result.output
    assert "5.00% in the force: settings of " in result.stderr
    assert "(model fem, element hex8-reduced, section of " in result.stderr
    ((scene, run),) = pulled
    assert (scene.contact.friction, scene.accuracy.wanted) == (0.2, 0.05)
    assert load_scene(run.scene_file) == scene
    refused = call("pull", "overhand", "--accuracy", "0.001%", "-o", "finer")
    assert refused.exit_code == 3
    assert "--accuracy: no settings were measured to be that accurate" in refused.stderr


def test_result_as_json(tmp_path):
    write_series(tmp_path / "costs" / "overhand", (PULL,), ["uniform"], failed="uniform-108")
    result = call("cost", "overhand", "--set", PULL, "--series", "uniform", "--store", "--log-format", "json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["folder"], found["table"]) == ("costs/overhand", "costs/overhand/cost.csv")
    assert (found["picture"], found["recommendation"]) == (
        "costs/overhand/cost.png", "costs/overhand/recommendation.json",
    )  # fmt: skip
    assert found["stored"] == str(tmp_path / "data" / "knotfem" / "recommendations.json")
    by_name = {row["rung"]: row for row in found["rungs"]}
    assert by_name["base"]["force_error"] > by_name["uniform-48"]["force_error"] > 0.0
    assert by_name["uniform-108"]["force_error"] is None
    assert found["references"]["force"][0]["source"].startswith("all refined at once")
    assert any(line.startswith("5% in the force: ") for line in found["recommendations"])


def test_store_without_a_bound_is_refused_after_the_table(tmp_path):
    write_series(tmp_path / "costs" / "overhand", (PULL,), ["slice"])
    result = call("cost", "overhand", "--set", PULL, "--ladder", "slice", "--store", tmp_path / "kept.json")
    assert result.exit_code == 3
    assert "nothing is recommended: the reference lacks section, step" in result.stdout
    assert "nothing bounds the reference" in result.stderr
    assert not (tmp_path / "kept.json").exists()


def test_effects_as_json(tmp_path):
    bare = ["rods.0.core=none", "drag=none", "contact.friction=0", "gravity=none", "inertia.scheme=quasi-static"]
    jobs = make_jobs("overhand", bare, tmp_path / "out", budget=None, tell=lambda text: None)
    without = Level("without-contact", "effects", "", None, ("contact.enabled=false",))
    for level in (base_level(), without):
        write_run(jobs.run_of(level), jobs.scene_of(level))
    options = [text for override in bare for text in ("--set", override)]
    result = call("cost", "overhand", *options, "--effects", "-o", "out", "--log-format", "json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["folder"], found["table"]) == ("out", "out/effects.csv")
    assert [(row["effect"], row["state"]) for row in found["effects"]] == [("contact", "done")]
    none = call("cost", "overhand", *options, "--set", "contact.enabled=false", "--effects", "-o", "none")
    assert none.exit_code == 3
    assert "--effects: no effect to switch off" in none.stderr
    assert not (tmp_path / "none").exists()


def test_effects_and_what_they_leave_out_are_not_taken_together():
    for option in (["--store"], ["--series", "slice"]):
        refused = call("cost", "overhand", "--effects", *option)
        assert refused.exit_code == 3
        assert f"{option[0]}: not with --effects" in refused.stderr


def test_wrong_options(tmp_path):
    assert "--budget" in call("cost", "overhand", "--budget", "").stderr
    assert call("cost", "overhand", "--series", "slices").exit_code == 3
    assert call("cost", "overhand", "--budget", "20").exit_code == 3
    assert call("cost", "overhand", "--jobs", "0").exit_code == 2
    assert call("pull", "overhand", "--accuracy", "2").exit_code == 3
    assert not (tmp_path / "costs").exists()
