"""What runs in a worker: an order is carried out in the worker's one thread, and ends when it is asked to."""

from __future__ import annotations

import gc
import hashlib
import shutil
import signal
import threading
import time
import traceback
from contextlib import suppress
from pathlib import Path
from typing import Any

from distributed import get_worker
from distributed.diagnostics.plugin import WorkerPlugin

from knotfem.errors import InUse, KnotfemError, Stopped
from knotfem.files import write_atomically
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive
from knotfem.run.memory_use import reset_peak_memory
from knotfem.study.engine.orders import Order, Reply, pack, unpack
from knotfem.version import __version__

CRASH_FILE = "crash.txt"
"""Where the traceback of a crash is."""
BUSY_POLL = 0.2
"""Seconds between looks whether another process has let go of a run directory."""


class Runs:
    """Runs under way in this process, which other threads can ask to stop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked: dict[str, tuple[str, threading.Event]] = {}
        self._over: set[str] = set()

    def begin(self, key: str, study: str) -> threading.Event:
        """The flag that the run of a task heeds; set already where its study is being stopped."""
        with self._lock:
            asked = threading.Event()
            if study in self._over:
                asked.set()
            self._asked[key] = study, asked
            return asked

    def end(self, key: str) -> None:
        """The run is over."""
        with self._lock:
            self._asked.pop(key, None)

    def stop(self, *, key: str | None = None, study: str | None = None) -> None:
        """Ask the run of a task, all runs of a study (also those to come), or all runs to stop."""
        with self._lock:
            if study is not None:
                self._over.add(study)
            for name, (of, asked) in self._asked.items():
                if (key is None or name == key) and (study is None or of == study):
                    asked.set()


RUNS = Runs()
_ONE_AT_A_TIME = threading.Lock()
"""Runs share compiled loops and libraries that are not made for several threads."""


class Watch(WorkerPlugin):
    """Asks runs to stop that nobody waits for any more, and all of them when the worker closes."""

    name = "knotfem"
    idempotent = True

    def setup(self, worker: Any) -> None:
        """Keep what a terminal sends from workers of this machine, and let SIGTERM stop runs in order."""
        if threading.current_thread() is threading.main_thread() and _is_child():
            for name in ("SIGINT", "SIGHUP"):
                if hasattr(signal, name):
                    signal.signal(getattr(signal, name), signal.SIG_IGN)
            signal.signal(signal.SIGTERM, _stop_first)

    def transition(self, key: Any, start: str, finish: str, **kwargs: Any) -> None:
        """Notice a task that was cancelled, such as by the end of its client."""
        if finish in ("cancelled", "released", "forgotten"):
            RUNS.stop(key=str(key))

    def teardown(self, worker: Any) -> None:
        """Stop what is under way."""
        RUNS.stop()


def _is_child() -> bool:
    """Whether this is a process of a local cluster, not one that was started by a command."""
    import multiprocessing

    return multiprocessing.parent_process() is not None


def _stop_first(number: int, frame: object) -> None:
    """Stop the runs of this process with a checkpoint; a second signal ends it."""
    RUNS.stop()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def stop_study(study: str) -> None:
    """Ask the runs of a study in this process to stop; the client sends it to all workers."""
    RUNS.stop(study=study)


def execute(order: Order) -> Reply:
    """Bring a run to its goal, from its last checkpoint if there is one; never raises for what the run does."""
    worker = get_worker()
    address, key = str(worker.address), str(worker.get_current_task())
    if order.version != __version__:
        reason = f"the worker {address} has knotfem {__version__}, the study is of {order.version}"
        return Reply("refused", reason, worker=address)
    with _ONE_AT_A_TIME:
        asked = RUNS.begin(key, order.study)
        try:
            shared = _reads(Path(order.marker), order.study)
            if not shared and order.files is None:
                return Reply("unseen", worker=address)
            folder = Path(order.folder) if shared else _fetch(order, Path(worker.local_directory))
            wall, cpu = time.perf_counter(), time.process_time()
            state, reason, code = _run(folder, order, asked)
            spent = time.perf_counter() - wall, time.process_time() - cpu
            files = None
            if not shared:
                files = pack(folder)
                shutil.rmtree(folder, ignore_errors=True)
            return Reply(state, reason, code, address, *spent, files)
        finally:
            RUNS.end(key)
            _free_memory()


def _run(folder: Path, order: Order, asked: threading.Event) -> tuple[Any, str, int]:
    """State, reason and exit code of a run that was gone on with."""
    _use_threads(order.threads)
    reset_peak_memory()
    try:
        run = RunDirectory.open(folder)
        if order.time_limit is not None:
            run.override([f"solver.time_limit={max(order.time_limit, 0.1):.3f} s"])
        _drive_when_free(run, order.goal, asked)
    except Stopped as error:
        return "asked" if asked.is_set() else "stopped", str(error), error.exit_code
    except KnotfemError as error:
        return "failed", str(error), error.exit_code
    except BaseException as error:
        with suppress(KnotfemError):
            write_atomically(folder / CRASH_FILE, traceback.format_exc())
        return "crashed", repr(error), 1
    return "done", "", 0


def _drive_when_free(run: RunDirectory, goal: str, asked: threading.Event) -> None:
    """Wait until no other process computes the run, such as a worker that was given up but still lives."""
    while True:
        try:
            with run.locked():
                return drive(run, goal, asked=asked)
        except InUse:
            if asked.wait(BUSY_POLL):
                raise Stopped("asked to stop while another process computes this run") from None


def _reads(marker: Path, study: str) -> bool:
    try:
        return marker.read_text(encoding="utf-8") == study
    except OSError:
        return False


def _fetch(order: Order, home: Path) -> Path:
    """The run directory in the worker's own folder; one that is there already has gone further than the client's."""
    assert order.files is not None
    name = hashlib.sha256(f"{order.marker} {order.folder}".encode()).hexdigest()[:20]
    folder = home / "knotfem-runs" / name
    if not RunDirectory.is_run(folder):
        folder.mkdir(parents=True, exist_ok=True)
        unpack(order.files, folder)
    return folder


def _free_memory() -> None:
    """Let go of the models of the run; what was imported and compiled with the first run is never looked at again."""
    gc.collect()
    if not gc.get_freeze_count():
        gc.freeze()


def _use_threads(count: int) -> None:
    """Let compiled loops take no more threads than the study says, whatever the worker was started with."""
    import numba
    from numba.core import config

    numba.set_num_threads(min(count, config.NUMBA_NUM_THREADS))  # pyright: ignore[reportAttributeAccessIssue]
