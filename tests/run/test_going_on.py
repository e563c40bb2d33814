"""A run goes on from what it was, or says why not: edited scenes, damaged files, sessions that were killed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import knotfem as kf
from knotfem.errors import InputError, NotConverged, Stopped
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive, goal_of
from knotfem.run.process import this_process
from knotfem.run.progress import Silent
from knotfem.run.stop import StopRequest
from knotfem.run.tables import read_table
from knotfem.scene import load_scene

QUICK = (
    "model=rod", "rods.0.length=400 mm", "rods.0.mesh.element_length=8 mm", "contact.enabled=false",
    "tie.increments=2", "steps.1.displacement=2 mm", "output.fields=false",
)  # fmt: skip


class Heard(Silent):
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.text = ""

    def message(self, text: str) -> None:
        self.text += text + "\n"


@pytest.fixture
def stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunDirectory:
    """A run that was tied and then stopped in its pull."""
    (tmp_path / "knot.csv").write_text(Path(load_scene("overhand").rods[0].curve_file).read_text())
    run = RunDirectory.create(
        load_scene("overhand", [*QUICK, f"rods.0.centerline={tmp_path}/knot.csv"]), tmp_path / "r"
    )
    drive(run, "tie")
    calls = iter(range(100))
    with monkeypatch.context() as patch:
        patch.setattr(StopRequest, "due", property(lambda self: next(calls) >= 6))
        with pytest.raises(Stopped):
            drive(run, "pull")
    return RunDirectory.open(run.path)


def edit(run: RunDirectory, before: str, after: str) -> None:
    text = run.scene_file.read_text()
    assert before in text
    run.scene_file.write_text(text.replace(before, after, 1))


WAYS = {
    "resume": lambda path: kf.resume(path, progress=False),
    "pull": lambda path: kf.pull(path, out=path, progress=False),
    "branch": lambda path: kf.pull(path, out=path.with_name("other"), progress=False),
    "in memory": lambda path: kf.pull(kf.open_run(path), progress=False),
    "read": lambda path: kf.open_run(path).tension(),
}


@pytest.mark.parametrize("way", WAYS)
def test_an_edited_scene_is_refused_with_its_key(stopped: RunDirectory, way: str) -> None:
    edit(stopped, "friction = 0.33", "friction = 0.5")
    with pytest.raises(InputError, match=r"scene\.toml: contact\.friction: changed since the run was computed") as said:
        WAYS[way](stopped.path)
    assert "found 0.5; expected 0.33" in str(said.value)


def test_further_kinds_of_edits(stopped: RunDirectory) -> None:
    whole = stopped.scene_file.read_text()
    for before, after, key in (
        ('displacement = "2 mm"', 'displacement = "3 mm"', "steps.1.displacement"),
        ("[contact]", '[gravity]\nacceleration = "9.81 m/s^2"\n[contact]', "gravity"),
    ):
        edit(stopped, before, after)
        with pytest.raises(InputError, match="changed since") as said:
            kf.resume(stopped.path, progress=False)
        assert said.value.key == key
        stopped.scene_file.write_text(whole)


def test_an_edited_curve_is_refused(stopped: RunDirectory) -> None:
    curve = Path(stopped.scene.rods[0].centerline)
    curve.write_text(curve.read_text() + "# another curve\n")
    with pytest.raises(InputError, match=r"rods\.0\.centerline: the file changed since") as said:
        kf.resume(stopped.path, progress=False)
    assert str(curve) in str(said.value)


def test_settings_and_records_may_be_edited(stopped: RunDirectory) -> None:
    edit(stopped, "max_iterations = 15", "max_iterations = 40")
    edit(stopped, "description = ", 'description = "mine" # ')
    assert kf.resume(stopped.path, progress=False).force.displacement[-1] == pytest.approx(2.0)


def test_a_damaged_checkpoint_gives_way_to_the_one_before(stopped: RunDirectory) -> None:
    newest = stopped.checkpoints.paths()[-1]
    newest.write_bytes(newest.read_bytes()[:-500])
    heard = Heard()
    drive(stopped, goal_of(stopped), heard)
    assert f"{newest} is damaged and removed; the run goes on from checkpoint-000002-tied.h5" in heard.text
    whole = RunDirectory.create(stopped.scene, stopped.path.with_name("whole"))
    drive(whole, "pull")
    for name, values in read_table(whole.path / "force.csv").items():
        assert name == "wall_s" or np.array_equal(values, read_table(stopped.path / "force.csv")[name])


@pytest.mark.parametrize("content", ["", "{", "[]", '{"state": "runn'])
def test_broken_records_do_not_block(stopped: RunDirectory, content: str) -> None:
    for name in ("status.json", "provenance.json"):
        (stopped.path / name).write_text(content)
    heard = Heard()
    drive(stopped, goal_of(stopped), heard)
    assert "status.json is damaged" in heard.text
    assert "provenance.json is damaged; it is set aside" in heard.text
    assert (stopped.path / "provenance.damaged.json").read_text() == content
    assert stopped.status["state"] == "done"


def test_additions_are_known_without_provenance(stopped: RunDirectory) -> None:
    metadata = {**stopped.checkpoints.metadata(), "additions": {"terms": ["wind"], "obstacles": [], "materials": []}}
    latest = stopped.checkpoints.latest()
    assert latest is not None
    stopped.checkpoints.save(latest.state, metadata)
    (stopped.path / "provenance.json").write_text("{")
    with pytest.raises(InputError, match=r"objects of your own are missing.*wind"):
        kf.resume(stopped.path, progress=False)


def test_a_session_that_was_killed_is_told(stopped: RunDirectory) -> None:
    status = {"state": "running", "goal": "pull", **this_process(), "process_started": 1.0}
    (stopped.path / "status.json").write_text(json.dumps(status))
    assert stopped.status["state"] == "stopped"
    heard = Heard()
    drive(stopped, goal_of(stopped), heard)
    assert f"the last session did not end in order: process {status['pid']} ended without saying why" in heard.text


def test_loose_rods_without_drag_and_inertia_are_told_what_to_give() -> None:
    real = ("steps.0.rate=real", "inertia.scheme=quasi-static", "solver.max_cutbacks=1", "contact.enabled=true")
    with pytest.raises(
        NotConverged, match=r"^relax: no balance at time 0 s.*neither drag nor inertia.*\[drag\] rate ="
    ):
        kf.tie("overhand", [*QUICK, *real], progress=False)
