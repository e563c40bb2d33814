"""Run directories: never overwritten by accident, never half there, held by one process."""

import errno
import json
import multiprocessing
import os
from multiprocessing.synchronize import Event
from pathlib import Path

import pytest

from knotfem import files
from knotfem.errors import InputError
from knotfem.run.columns import FORCE_COLUMNS, TIE_COLUMNS
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.scene import Scene, load_scene


@pytest.fixture
def run(scene: Scene, tmp_path: Path) -> RunDirectory:
    return RunDirectory.create(scene, tmp_path / "run")


def test_the_scene_comes_back(run: RunDirectory, scene: Scene) -> None:
    assert RunDirectory.open(run.path).scene == scene
    assert load_scene(run.path / "scene.toml") == scene
    assert RunDirectory.is_run(run.path)


def test_default_folders_are_numbered(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert [str(RunDirectory.create(scene).path) for _ in range(2)] == ["runs/bowline-1", "runs/bowline-2"]


def test_a_run_is_not_overwritten(run: RunDirectory, scene: Scene) -> None:
    run.write_summary({"steps": 3})
    with pytest.raises(InputError, match=r"holds a run already.*--force"):
        RunDirectory.create(scene, run.path)
    assert run.read_summary() == {"steps": 3}


def test_force_removes_what_the_run_wrote_and_nothing_else(run: RunDirectory, scene: Scene) -> None:
    run.write_summary({"steps": 3})
    DiskStore(run).log({"step": 1})
    run.checkpoints.save({}, {})
    for name in ("stretch.png", "stretch-red.png", "knot-twist.png"):
        (run.path / name).write_text("drawn")
    (run.path / "notes.txt").write_text("mine")
    again = RunDirectory.create(scene, run.path, force=True)
    assert sorted(os.listdir(again.path)) == ["notes.txt", "scene.toml"]


def test_other_folders_are_left_alone(scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    for force in (False, True):
        with pytest.raises(InputError, match="holds other files"):
            RunDirectory.create(scene, tmp_path, force=force)
        with pytest.raises(InputError, match="this is a file"):
            RunDirectory.create(scene, tmp_path / "letter.txt", force=force)
    assert os.listdir(tmp_path) == ["letter.txt"]


def test_a_folder_that_cannot_be_made(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, *args: object, **more: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(InputError, match=r"new: cannot be written \(Permission denied\)"):
        RunDirectory.create(scene, tmp_path / "new")


def test_a_full_disk_leaves_no_run(scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(InputError, match=r"scene\.toml: cannot be written \(No space left on device\)"):
        RunDirectory.create(scene, tmp_path / "new")
    assert os.listdir(tmp_path) == []


def test_no_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such run"):
        RunDirectory.open(tmp_path / "none")
    with pytest.raises(InputError, match="no run is in this folder"):
        RunDirectory.open(tmp_path)


def test_status(run: RunDirectory) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        run.read_status()
    assert run.status == {}
    run.write_status("running", phase="pull", displacement_mm=3.0)
    status = run.read_status()
    assert (status["state"], status["phase"], status["displacement_mm"]) == ("running", "pull", 3.0)
    assert status["pid"] == os.getpid()
    assert run.status == status


def test_log(run: RunDirectory) -> None:
    store = DiskStore(run)
    assert store.logged == 0
    store.log({"step": 1, "force_N": 0.5})
    store.log({"step": 2, "force_N": float("nan")})
    lines = [json.loads(line) for line in (run.path / "log.jsonl").read_text().splitlines()]
    assert lines == [{"step": 1, "force_N": 0.5}, {"step": 2, "force_N": None}]
    assert store.logged == 2
    store.keep_log(1)
    assert [json.loads(line) for line in (run.path / "log.jsonl").read_text().splitlines()] == lines[:1]


def test_tables(run: RunDirectory) -> None:
    store = DiskStore(run)
    table = store.table("force", ("wall_s", "work_Nmm"))
    assert table.path == run.path / "force.csv"
    assert table.path.read_text() == "wall_s,work_Nmm\n"


def test_settings_may_change_the_rest_may_not(run: RunDirectory, scene: Scene) -> None:
    run.override(["solver.threads=1", "output.checkpoint_every=5 s"])
    assert (run.scene.solver.threads, run.scene.output.checkpoint_every) == (1, 5.0)
    assert RunDirectory.open(run.path).scene == scene
    with pytest.raises(InputError, match=r"^overrides: contact\.friction: cannot change in a run; found 0\.1"):
        run.override(["contact.friction=0.1"])


def test_branches_go_on_from_the_tied_knot(run: RunDirectory, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not tied yet"):
        run.branch(run.scene, tmp_path / "other")
    store = DiskStore(run)
    tie = store.table("tie", TIE_COLUMNS)
    tie.append(dict.fromkeys(TIE_COLUMNS, 1.0))
    run.checkpoints.save({"x": 1.0}, {}, name=TIED)
    store.table("force", (*FORCE_COLUMNS, "taken_Nmm")).append(dict.fromkeys((*FORCE_COLUMNS, "taken_Nmm"), 2.0))
    run.checkpoints.save({"x": 2.0}, {})
    assert run.tied
    firm = load_scene(run.scene_file, ["contact.friction=0.37", "obstacles.0.friction=0.01", "steps.1.speed=2 mm/s"])
    other = run.branch(firm, tmp_path / "other")
    checkpoint = other.checkpoints.latest()
    assert checkpoint is not None
    assert checkpoint.state == {"x": 1.0}
    assert other.tied
    assert other.scene == firm
    assert (other.path / "tie.csv").read_text() == tie.path.read_text()
    assert DiskStore(other).table("force", FORCE_COLUMNS).rows == 0


@pytest.mark.parametrize(
    "override",
    ["rods.0.diameter=5 mm", "obstacles.0.diameter=19 mm", "tie.degree=4", "model=rod", "contact.enabled=false"],
)
def test_branches_have_the_same_knot(run: RunDirectory, tmp_path: Path, override: str) -> None:
    run.checkpoints.save({}, {}, name=TIED)
    with pytest.raises(InputError, match="differs from the tied run") as caught:
        run.branch(load_scene(run.scene_file, [override]), tmp_path / "other")
    assert caught.value.key == override.partition("=")[0]
    assert not (tmp_path / "other").exists()


def _hold(path: Path, held: Event, done: Event) -> None:
    with RunDirectory(path).locked():
        held.set()
        done.wait(20)


def test_one_process_at_a_time(run: RunDirectory) -> None:
    context = multiprocessing.get_context("fork")
    held, done = context.Event(), context.Event()
    other = context.Process(target=_hold, args=(run.path, held, done))
    other.start()
    assert held.wait(20)
    with pytest.raises(InputError, match="another process"), run.locked():
        pass
    other.kill()
    other.join()
    with run.locked():
        pass
    assert os.listdir(run.path.parent) == [run.path.name]


def test_a_run_in_a_folder_that_is_not_ours(run: RunDirectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with run.locked():
        assert os.listdir(run.path.parent) == [run.path.name]
        with pytest.raises(InputError, match="another process"), RunDirectory(run.path).locked():
            pass
    assert os.listdir(run.path) == ["scene.toml"]


def test_what_a_crash_left_is_swept(run: RunDirectory) -> None:
    (run.path / f".force.csv.1{files.PART_SUFFIX}").write_text("half")
    with run.locked():
        assert os.listdir(run.path) == ["scene.toml"]
