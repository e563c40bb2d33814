"""Hands runs out to workers and yields them as they end; what ends may call for more."""

from __future__ import annotations

import heapq
import queue
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from knotfem.errors import Interrupted, InUse, KnotfemError, Stopped
from knotfem.files import held, write_atomically
from knotfem.run.directory import RunDirectory
from knotfem.run.stop import StopRequest
from knotfem.scene.model import Scene
from knotfem.study.engine.orders import Order, Reply, pack, unpack
from knotfem.study.engine.outcomes import CRASHED, Outcome
from knotfem.study.engine.places import Place, page_of, workers_of
from knotfem.version import __version__

if TYPE_CHECKING:
    from distributed import Client, Future

MARKER = ".knotfem-study"
"""File of a study's folder by which workers know that they share the disk; there while the study runs."""
LOCK = ".knotfem-study.lock"
POLL = 0.2
"""Seconds between looks for a request to stop."""
LOOK = 2.0
"""Seconds between looks how many workers there are."""
LOSSES = 2
"""How often in a row all workers that took a run may die (four each time) without a new checkpoint."""
STOP_PATIENCE = 300.0
"""Seconds that runs have to write their checkpoints."""
RESUME = "stopped; checkpoints are written, the same command goes on"


@dataclass(frozen=True, eq=False)
class Job:
    """A run to bring to its goal.

    Attributes:
        name: of the run in its study.
        run: its directory, with a scene and perhaps checkpoints; a tied knot that it was branched from is one.
        scene: with which the directory is made when the run is handed out; None where it is there already.
        goal: "tie" or "pull".
        time_limit: wall time after which it stops with a checkpoint [s], or none.
        memory_mb: that it is expected to take; on this machine it waits until there is so much.
    """

    name: str
    run: RunDirectory
    scene: Scene | None = None
    goal: str = "pull"
    time_limit: float | None = None
    memory_mb: float = 0.0

    def prepare(self) -> None:
        """Make the run directory if it is not there."""
        if self.scene is not None and not RunDirectory.is_run(self.run.path):
            RunDirectory.create(self.scene, self.run.path)


@dataclass(frozen=True, eq=False)
class Ended:
    """A run that has ended.

    Attributes:
        job: as it was submitted.
        outcome: what became of it; its directory holds the results.
        worker: address of the one that ended it.
        wall_s: wall time of its last session [s].
        cpu_s: CPU time likewise [s].
    """

    job: Job
    outcome: Outcome
    worker: str = ""
    wall_s: float = 0.0
    cpu_s: float = 0.0


@dataclass(eq=False)
class _Out:
    """A job that workers have."""

    job: Job
    checkpoint: str
    losses: int = 0


class Engine:
    """Brings run directories to their goals on many workers.

        with Engine(folder, place) as engine:
            for job in first:
                engine.submit(job)
            for ended in engine.results():
                for job in what_follows_from(ended):        # a bisection goes on
                    engine.submit(job, priority=1.0)        # before what waits with a lower one

    Workers are started, or a scheduler is contacted, when the first run is submitted. No more runs are handed out than
    there are workers, so that those submitted later with a higher priority come first. A run whose worker dies goes on
    from its last checkpoint on another one. SIGTERM and Ctrl-C are taken as requests to stop: all runs write a
    checkpoint, then `wait` and `results` raise.

    Args:
        folder: of the study; made if it is not there, and held against other processes meanwhile.
        place: where the workers are.
        tell: told what a user should know.
        eager: whether a worker gets what waits as soon as its run has ended, before that run is yielded: no worker
            waits for whoever takes the results, but what they call for comes one run later.

    Raises:
        InUse: on entering: another process is at work on the folder.
    """

    def __init__(self, folder: Path, place: Place, *, tell: Callable[[str], None], eager: bool = False) -> None:
        self.folder, self.place, self.tell, self.eager = folder.resolve(), place, tell, eager
        self.study = uuid.uuid4().hex
        self._stop = StopRequest()
        self._stack = ExitStack()
        self._client: Client | None = None
        self._waiting: list[tuple[float, int, Job]] = []
        self._numbers = count()
        self._out: dict[str, _Out] = {}
        self._futures: dict[str, Future] = {}
        self._ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._send_files = False
        self._workers, self._looked, self._told_waiting = 0, float("-inf"), False

    def __enter__(self) -> Self:
        try:
            self._stack.enter_context(self._stop)
            self.folder.mkdir(parents=True, exist_ok=True)
            busy = InUse("another process is at work on this study", file=self.folder)
            self._stack.enter_context(held(self.folder / LOCK, busy))
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._stack:
            if self._out and not isinstance(error, KeyboardInterrupt):
                with suppress(Exception):
                    self._halt()

    @property
    def running(self) -> int:
        """Runs that workers have."""
        return len(self._out)

    @property
    def waiting(self) -> int:
        """Runs that no worker has yet."""
        return len(self._waiting)

    @property
    def busy(self) -> bool:
        """Whether something is still to end."""
        return bool(self._out or self._waiting)

    @property
    def free(self) -> int:
        """Workers that have nothing to do, once all that waits is handed out; connects."""
        self._look()
        return max(self._workers - len(self._out) - len(self._waiting), 0)

    def submit(self, job: Job, *, priority: float = 0.0) -> None:
        """Add a run; it is handed out by `wait` and `results`.

        Args:
            job: the run.
            priority: higher ones first, those of equal priority in the order of submission.
        """
        heapq.heappush(self._waiting, (-priority, next(self._numbers), job))

    def withdraw(self, unwanted: Callable[[Job], bool]) -> list[Job]:
        """Take back runs that no worker has yet.

        Args:
            unwanted: tells which.

        Returns:
            Those that were taken back.
        """
        taken = [entry for entry in self._waiting if unwanted(entry[2])]
        self._waiting = [entry for entry in self._waiting if not unwanted(entry[2])]
        heapq.heapify(self._waiting)
        return [job for _, _, job in taken]

    def results(self) -> Iterator[Ended]:
        """Yield runs as they end, until none is left; more may be submitted meanwhile.

        Raises:
            Stopped: by SIGTERM; all runs have written checkpoints.
            Interrupted: by Ctrl-C, likewise.
            KnotfemError: the scheduler is gone, or the workers cannot serve.
        """
        while self.busy:
            ended = self.wait()
            if ended is not None:
                yield ended

    def wait(self, timeout: float = POLL) -> Ended | None:
        """Hand out what can be, and wait for the next run that ends.

        Args:
            timeout: seconds after which None is returned.

        Raises:
            KnotfemError: see `results`.
        """
        if self._stop.due:
            self._halt()
            error = self._stop.error()
            raise (Interrupted if isinstance(error, Interrupted) else Stopped)(RESUME)
        self._hand_out()
        for _, _, job in heapq.nsmallest(self._workers, self._waiting):
            job.prepare()  # while the workers work
        try:
            future = self._ended.get(timeout=timeout)
        except queue.Empty:
            return None
        ended = self._take(future)
        if self.eager:
            self._hand_out()
        return ended

    def _connected(self) -> Client:
        if self._client is None:
            from knotfem.study.engine.execute import Watch

            self._client = client = self._stack.enter_context(self.place.client())
            marker = self.folder / MARKER
            write_atomically(marker, self.study)
            self._stack.callback(marker.unlink, missing_ok=True)
            client.register_plugin(Watch())
            page = page_of(self.place, client)
            if page:
                self.tell(f"dashboard: {page}")
        return self._client

    def _look(self) -> None:
        """Note, once in a while, how many workers there are."""
        client = self._connected()
        if self._workers and time.monotonic() - self._looked < LOOK:
            return
        self._looked = time.monotonic()
        if client.status != "running":
            raise self._lost()
        self.place.renew()
        workers = workers_of(client)
        self._workers = self.place.capacity(workers)
        if not workers and not self._told_waiting:
            self._told_waiting = True
            self.tell("waiting for workers")

    def _hand_out(self) -> None:
        """Give workers that have nothing to do what waits, as far as memory allows."""
        if not self.busy:
            return
        self._look()
        while self._waiting and len(self._out) < self._workers:
            job = self._waiting[0][2]
            if self._out and self._crowded(job):
                return
            heapq.heappop(self._waiting)
            job.prepare()
            self._send(_Out(job, _newest(job.run)))

    def _crowded(self, job: Job) -> bool:
        """Whether a run has to wait until others have given their memory back."""
        import psutil

        return self.place.local and job.memory_mb > psutil.virtual_memory().available / 1e6

    def _send(self, out: _Out) -> None:
        from knotfem.study.engine.execute import execute

        job = out.job
        order = Order(
            str(job.run.path.resolve()),
            self.study,
            str(self.folder / MARKER),
            job.goal,
            self.place.threads,
            __version__,
            job.time_limit,
            pack(job.run.path) if self._send_files else None,
        )
        key = f"knotfem-{uuid.uuid4().hex}"
        self._out[key] = out
        future = self._connected().submit(execute, order, key=key, pure=False)
        self._futures[key] = future
        future.add_done_callback(self._ended.put)

    def _take(self, future: Future) -> Ended | None:
        """What became of a run, or None where it is handed out again."""
        out = self._claim(future)
        if out is None:
            return None
        if future.status == "cancelled" or future.cancelled():
            raise self._lost()
        error: Any = future.exception()
        if error is not None:
            return self._worker_lost(out, error)
        reply: Reply = future.result()
        return self._answered(out, reply)

    def _claim(self, future: Future) -> _Out | None:
        """The job that a future stands for, which no worker has any more; None where nobody waits for it."""
        key = str(future.key)
        self._futures.pop(key, None)
        return self._out.pop(key, None)

    def _answered(self, out: _Out, reply: Reply) -> Ended | None:
        job = out.job
        if reply.files is not None:
            unpack(reply.files, job.run.path)
        if reply.state == "refused":
            raise KnotfemError(f"{reply.reason}; cure: the same version everywhere")
        if reply.state == "unseen":
            self._send_files = True
        if reply.state in ("unseen", "asked") and not self._stop.due:
            self._send(replace(out, losses=0))
            return None
        if reply.state == "done":
            outcome = Outcome("done")
        elif reply.state in ("asked", "stopped", "unseen"):
            outcome = Outcome("stopped", "out of time or asked to; the same command goes on")
        elif reply.state == "failed":
            outcome = Outcome("failed", reply.reason, reply.exit_code)
        else:
            again = "its folder has crash.txt; the same command tries again"
            outcome = Outcome("failed", f"crashed: {reply.reason}; {again}", CRASHED)
        return Ended(job, outcome, reply.worker, reply.wall_s, reply.cpu_s)

    def _worker_lost(self, out: _Out, error: BaseException) -> Ended | None:
        """Hand out again what went on since its last checkpoint; a run that kills every worker has crashed."""
        from distributed import KilledWorker

        if not isinstance(error, KilledWorker):
            raise KnotfemError(f"the workers cannot serve: {error!r}; cure: knotfem installed where they run")
        newest = _newest(out.job.run)
        losses = out.losses + 1 if newest == out.checkpoint else 0
        if losses < LOSSES:
            self.tell(f"{out.job.name}: its worker died, it goes on elsewhere")
            self._send(replace(out, checkpoint=newest, losses=losses))
            return None
        reason = "crashed: its workers died again and again (out of memory?); the same command tries again"
        return Ended(out.job, Outcome("failed", reason, CRASHED))

    def _halt(self) -> None:
        """Let all runs write their checkpoints and take back what travels."""
        from knotfem.study.engine.execute import stop_study

        self._waiting.clear()
        client = self._client
        if client is None or client.status != "running":
            return
        client.run(stop_study, self.study, on_error="ignore")
        deadline = time.monotonic() + STOP_PATIENCE
        while self._out and time.monotonic() < deadline:
            with suppress(queue.Empty):
                future = self._ended.get(timeout=POLL)
                out = self._claim(future)
                if out is not None and future.status == "finished":
                    reply: Reply = future.result()
                    if reply.files is not None:
                        unpack(reply.files, out.job.run.path)
        self._out.clear()
        self._futures.clear()

    def _lost(self) -> KnotfemError:
        self._out.clear()
        return KnotfemError("the scheduler is gone; the same command goes on from the last checkpoints")


def _newest(run: RunDirectory) -> str:
    """Name of the newest checkpoint, or ""."""
    paths = run.checkpoints.paths()
    return paths[-1].name if paths else ""
