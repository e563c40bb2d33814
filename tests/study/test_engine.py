"""The engine on a small cluster: workers that die, clients that go, disks that are not shared."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
from distributed import Client, LocalCluster

import knotfem as kf
from knotfem.errors import InputError, Interrupted, InUse
from knotfem.run.directory import RunDirectory
from knotfem.study.engine import engine as module
from knotfem.study.engine.engine import Ended, Engine, Job
from knotfem.study.engine.places import Local, Place, Scheduler

KNOT: dict[str, Any] = {
    "model": "rod",
    "rods.0.length": "400 mm",
    "rods.0.mesh.element_length": "8 mm",
    "contact.sample_spacing_over_diameter": 0.25,
    "tie.path": "direct",
    "steps.pull.displacement": "2 mm",
    "output.fields": False,
    "output.checkpoint_every": "0.01 s",
    "solver.threads": 1,
}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler with one worker, as the user starts them."""
    with Local(1).client() as client:
        yield cast(LocalCluster, client.cluster).scheduler_address


@pytest.fixture(scope="module")
def undisturbed() -> kf.Run:
    return kf.pull("overhand", KNOT)


def job(folder: Path, name: str = "knot", **changed: Any) -> Job:
    scene = kf.load_scene("overhand", {**KNOT, **changed})
    return Job(name, RunDirectory(folder / "runs" / name), scene)


def same_forces(ended: Ended, run: kf.Run) -> bool:
    return bool((kf.open_run(ended.job.run.path).force.force == run.force.force).all())


def when(condition: Callable[[], object], act: Callable[[], object]) -> threading.Thread:
    """Act once a condition holds."""

    def wait() -> None:
        deadline = time.monotonic() + 60.0
        while not condition() and time.monotonic() < deadline:
            time.sleep(0.005)
        act()

    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def test_results_may_call_for_more_and_priority_counts(address: str, tmp_path: Path, undisturbed: kf.Run) -> None:
    order: list[str] = []
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        engine.submit(job(tmp_path, "first"))
        engine.submit(job(tmp_path, "last", **{"rods.0.mesh.element_length": "9 mm"}))
        engine.submit(job(tmp_path, "unwanted"))
        for ended in engine.results():
            order.append(ended.job.name)
            if order == ["first"]:
                assert same_forces(ended, undisturbed)
                assert ended.wall_s > 0.0
                engine.submit(job(tmp_path, "urgent", **{"rods.0.mesh.element_length": "10 mm"}), priority=1.0)
                assert [one.name for one in engine.withdraw(lambda one: one.name == "unwanted")] == ["unwanted"]
        assert engine.free == 1
    assert order == ["first", "urgent", "last"]
    assert not any(path.name.startswith(".") for path in tmp_path.iterdir())


def test_run_goes_on_from_its_checkpoint_when_its_worker_is_killed(
    address: str, tmp_path: Path, undisturbed: kf.Run
) -> None:
    with Client(address, set_as_default=False) as client:
        (pid,) = cast(dict[str, int], client.run(os.getpid)).values()
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        one = job(tmp_path)
        engine.submit(one)
        killer = when(lambda: one.run.checkpoints.named("tied"), lambda: os.kill(pid, signal.SIGKILL))
        (ended,) = engine.results()
        killer.join()
    assert ended.outcome.state == "done"
    assert same_forces(ended, undisturbed)
    log = (one.run.path / "provenance.json").read_text()
    assert log.count('"start"') == 3, "two sessions, the newest also at the top"


def test_ctrl_c_leaves_checkpoints(address: str, tmp_path: Path, undisturbed: kf.Run) -> None:
    one = job(tmp_path)
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        engine.submit(one)
        begun = one.run.path / "log.jsonl"
        interrupt = when(begun.exists, lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(Interrupted, match="the same command goes on"):
            list(engine.results())
    interrupt.join()
    assert one.run.status["state"] == "stopped"
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        engine.submit(one)
        (ended,) = engine.results()
    assert same_forces(ended, undisturbed)


class Leaving(Place):
    """A scheduler whose client goes without a word."""

    def __init__(self, address: str) -> None:
        self.address, self.left = address, False

    @property
    def slots(self) -> int:
        return 1

    def client(self) -> AbstractContextManager[Client]:
        self.made = Client(self.address, set_as_default=False)
        return nullcontext(self.made)


def test_run_stops_when_its_client_is_gone(address: str, tmp_path: Path, undisturbed: kf.Run) -> None:
    one, place = job(tmp_path), Leaving(address)
    with Engine(tmp_path, place, tell=lambda text: None) as engine:
        engine.submit(one)
        while not one.run.checkpoints.named("tied"):
            engine.wait(0.01)
        place.made.close()
    deadline = time.monotonic() + 30.0
    while one.run.status["state"] == "running" and time.monotonic() < deadline:
        time.sleep(0.02)
    assert one.run.status["state"] == "stopped"


def test_run_directory_travels_where_the_disk_is_not_shared(
    address: str, tmp_path: Path, undisturbed: kf.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "write_atomically", lambda path, text: path.write_text("of another study"))
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        first, second = job(tmp_path), job(tmp_path, "limited")
        engine.submit(first)
        engine.submit(replace(second, time_limit=0.1))
        found = {ended.job.name: ended for ended in engine.results()}
        assert found["knot"].outcome.state == "done"
        assert same_forces(found["knot"], undisturbed)
        assert found["limited"].outcome.state == "stopped"
        engine.submit(second)
        (ended,) = engine.results()
    assert same_forces(ended, undisturbed)


def test_failure_is_a_result(address: str, tmp_path: Path) -> None:
    hopeless = job(tmp_path, "hopeless", **{"solver.max_iterations": 1, "solver.max_cutbacks": 0})
    with Engine(tmp_path, Scheduler(address), tell=lambda text: None) as engine:
        engine.submit(hopeless)
        (ended,) = engine.results()
    assert (ended.outcome.state, ended.outcome.exit_code) == ("failed", 4)
    assert ended.outcome.reason == hopeless.run.status["reason"]


def test_one_process_at_a_time_works_on_a_study(tmp_path: Path) -> None:
    with Engine(tmp_path, Local(1), tell=lambda text: None), pytest.raises(InUse, match="another process"):
        Engine(tmp_path, Local(1), tell=lambda text: None).__enter__()
    with Engine(tmp_path, Local(1), tell=lambda text: None) as engine:
        assert not engine.busy


@pytest.mark.parametrize("wrong", ["tcp://127.0.0.1:9", "nowhere"])
def test_no_scheduler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: str) -> None:
    monkeypatch.setattr("knotfem.study.engine.places.CONNECT_TIMEOUT", 0.5)
    with Engine(tmp_path, Scheduler(wrong), tell=lambda text: None) as engine:
        engine.submit(job(tmp_path))
        with pytest.raises(InputError, match="--scheduler: no scheduler answers"):
            list(engine.results())
