"""`knotfem cost` and `knotfem pull --accuracy` on runs whose results follow a known law."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from manufactured import write_ladders

import knotfem.run
from knotfem.cost.records import stored
from knotfem.scene import load_scene
from knotfem_cli.main import knotfem_command

PULL = "steps.1.displacement=30 mm"
LADDERS = ("section", "slice")


def call(*arguments: object) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def measured(tmp_path: Path) -> Result:
    write_ladders(tmp_path / "costs" / "overhand", (PULL,), LADDERS)
    chosen = [text for name in LADDERS for text in ("--ladder", name)]
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
    assert record["scene"] == "overhand"
    assert "overhand" not in [entry.scene for entry in stored() if entry.window == pytest.approx(5.0)]


def test_accuracy_takes_what_cost_stored(measured, tmp_path, monkeypatch):
    (tmp_path / "data" / "knotfem").mkdir(parents=True)
    (tmp_path / "kept.json").rename(tmp_path / "data" / "knotfem" / "recommendations.json")
    pulled = []

    class Driver:
        @staticmethod
        def pull(scene, run, progress) -> None:
            pulled.append((scene, run))

    monkeypatch.setattr(knotfem.run, "driver", Driver, raising=False)
    result = call(
        "pull", "overhand", "--accuracy", "5%", "--model", "fem", "--set", "contact.friction=0.2", "-o", "out"
    )
    assert result.exit_code == 0, result.output
    assert "5.00% in the force: settings of " in result.stderr
    ((scene, run),) = pulled
    assert (scene.contact.friction, scene.accuracy.wanted) == (0.2, 0.05)
    assert load_scene(run.scene_file) == scene
    refused = call("pull", "overhand", "--accuracy", "0.001%", "-o", "finer")
    assert refused.exit_code == 3
    assert "--accuracy: no settings were measured to be that accurate" in refused.stderr


def test_wrong_options(tmp_path):
    assert call("cost", "overhand", "--ladder", "slices").exit_code == 3
    assert call("cost", "overhand", "--budget", "20").exit_code == 3
    assert call("cost", "overhand", "--jobs", "0").exit_code == 2
    assert call("pull", "overhand", "--accuracy", "2").exit_code == 3
    assert not (tmp_path / "costs").exists()
