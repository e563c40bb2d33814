"""Runs of variants of a scene in processes of their own: cheapest first, within a budget, resumable."""

from __future__ import annotations

import logging
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from knotfem.errors import InputError, Interrupted, KnotfemError, KnotLost, NotConverged, Stopped
from knotfem.results.data import open_run
from knotfem.run.directory import RunDirectory
from knotfem.run.expected import START_SECONDS, expected_memory_mb, expected_seconds
from knotfem.run.stop import StopRequest
from knotfem.scene.model import Scene
from knotfem.study.refinement import BASE, Level
from knotfem.threads import VARIABLES

LOG = logging.getLogger("knotfem")
State = Literal["done", "failed", "stopped", "left out"]
POLL = 0.1
"""Seconds between looks at the processes."""
WORKER = (sys.executable, "-m", "knotfem.study.worker")
OUTPUT = "worker.log"
"""What the process of a run prints."""
STOPPED = (Stopped.exit_code, Interrupted.exit_code, -signal.SIGTERM, -signal.SIGINT)
"""Exit codes of processes that were asked to stop, also before they could write a checkpoint."""
FAILURES = {kind.exit_code: kind for kind in (InputError, NotConverged, KnotLost)}
"""Failures that are results, by exit code; any other end is a crash."""


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        state: "done"; "failed", which is a result; "stopped" with a checkpoint; "left out" by the budget.
        reason: why it is not done.
        exit_code: of a failed one's process.
    """

    state: State
    reason: str = ""
    exit_code: int = 0


@dataclass(frozen=True, eq=False)
class _Working:
    """A process at work on a level, since a time on the clock of `time.monotonic`."""

    level: Level
    process: subprocess.Popen[bytes]
    began: float


@dataclass(eq=False)
class Jobs:
    """Runs of the refinement levels of one scene, in one folder.

    Args:
        folder: run directories go to its subfolder runs.
        scene_of: the scene of a level.
        processes: at a time.
        threads: of each process.
        deadline: on the clock of `time.monotonic`, or none.
        tell: told what starts, ends and is left out.
    """

    folder: Path
    scene_of: Callable[[Level], Scene]
    processes: int
    threads: int
    deadline: float = float("inf")
    tell: Callable[[str], None] = LOG.info
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    _pace: list[float] = field(default_factory=list)

    def run_of(self, level: Level) -> RunDirectory:
        """The run directory of a level, there or not."""
        return RunDirectory(self.folder / "runs" / level.name)

    def run(self, levels: Sequence[Level]) -> None:
        """Bring levels to an outcome; those that have one in the folder keep it.

        Raises:
            Stopped: by SIGTERM. Checkpoints are written.
            Interrupted: by Ctrl-C, likewise.
            InputError: a folder holds a run of another scene.
        """
        waiting = [level for level in levels if self._possible(level) and not self._known(level)]
        waiting.sort(key=lambda level: (level.name != BASE, process_seconds(self.scene_of(level)), level.name))
        working: list[_Working] = []
        with StopRequest() as stop:
            try:
                while waiting or working:
                    if stop.due:
                        raise stop.error()
                    self._start_next(waiting, working)
                    time.sleep(POLL)
                    self._collect(working)
            except (Stopped, Interrupted) as error:
                raise type(error)("stopped; checkpoints are written, the same command goes on") from None
            finally:
                for one in working:
                    one.process.terminate()
                for one in working:
                    one.process.wait()

    def _start_next(self, waiting: list[Level], working: list[_Working]) -> None:
        """Start levels that wait, as far as processes, memory and budget allow."""
        while waiting and len(working) < self.processes and not (working and self._crowded(waiting[0])):
            level = waiting.pop(0)
            if self._fits(level):
                working.append(_Working(level, self._start(level), time.monotonic()))

    def _collect(self, working: list[_Working]) -> None:
        """Take note of processes that have ended."""
        for one in list(working):
            if one.process.poll() is not None:
                working.remove(one)
                self._ended(one.level, one.process.returncode, time.monotonic() - one.began)

    def _possible(self, level: Level) -> bool:
        """Whether a level is a valid scene; one that is not has failed, and for the base the error is raised."""
        try:
            self.scene_of(level)
        except InputError as error:
            if level.name == BASE:
                raise
            self.outcomes[level.name] = Outcome("failed", str(error), error.exit_code)
            return False
        return True

    def _known(self, level: Level) -> bool:
        """Whether the folder holds an outcome of a level already."""
        run, scene = self.run_of(level), self.scene_of(level)
        if level.name in self.outcomes and self.outcomes[level.name].state in ("done", "failed"):
            return True
        if not RunDirectory.is_run(run.path):
            return False
        if _physics(run.scene) != _physics(scene):
            raise InputError("the folder holds a run of another scene", file=run.path, expected="another folder (-o)")
        status = run.status
        state = status.get("state")
        if state not in ("done", "failed"):
            return False
        code = int(status.get("exit_code", NotConverged.exit_code)) if state == "failed" else 0
        if code and code not in FAILURES:
            return False
        self.outcomes[level.name] = Outcome(state, str(status.get("reason", "")), code)
        if state == "done":
            self._learn(scene, START_SECONDS + _spent(run))
        self.tell(f"{level.name}: {state} already")
        return True

    def _fits(self, level: Level) -> bool:
        left = self.deadline - time.monotonic()
        needed = self.expected(level)
        hopeless = BASE in self.outcomes and self.outcomes[BASE].state == "failed"
        if level.name == BASE or (needed <= left and not hopeless):
            self.tell(f"{level.name}: started, about {needed / 60.0:.1f} min ({level.setting})")
            return True
        reason = (
            "the scene itself fails"
            if hopeless
            else f"needs about {needed / 60.0:.1f} min, {max(left, 0.0) / 60.0:.1f} min are left of the budget"
        )
        self.outcomes[level.name] = Outcome("left out", reason)
        self.tell(f"{level.name}: left out, {reason}")
        return False

    def _crowded(self, level: Level) -> bool:
        """Whether a level has to wait until others have given their memory back."""
        import psutil

        return expected_memory_mb(self.scene_of(level)) > psutil.virtual_memory().available / 1e6

    def expected(self, level: Level) -> float:
        """Wall seconds that a level still needs, by the pace of those that are done."""
        needed = process_seconds(self.scene_of(level)) * (statistics.median(self._pace) if self._pace else 1.0)
        return max(needed - _spent(self.run_of(level)), 0.1 * needed)

    def _start(self, level: Level) -> subprocess.Popen[bytes]:
        run, scene = self.run_of(level), self.scene_of(level)
        if not RunDirectory.is_run(run.path):
            RunDirectory.create(scene, run.path)
        command = [*WORKER, str(run.path)]
        if self.deadline < float("inf"):
            command.append(f"{max(self.deadline - time.monotonic(), 1.0):.1f}")
        environment = {**os.environ, **dict.fromkeys(VARIABLES, str(self.threads))}
        with (run.path / OUTPUT).open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, env=environment)

    def _ended(self, level: Level, code: int, seconds: float) -> None:
        run = self.run_of(level)
        reason = str(run.status.get("reason", ""))
        if code == 0:
            self.outcomes[level.name] = Outcome("done")
            self._learn(run.scene, START_SECONDS + _spent(run))
        elif code in STOPPED:
            self.outcomes[level.name] = Outcome("stopped", "out of time or asked to; the same command goes on")
        else:
            crashed = f"the process ended with {code}, see {run.path / OUTPUT}; the same command tries again"
            self.outcomes[level.name] = Outcome("failed", reason if reason and code in FAILURES else crashed, code)
        outcome = self.outcomes[level.name]
        self.tell(f"{level.name}: {outcome.state} after {seconds:.0f} s" + (f", {outcome.reason}" if code else ""))

    def _learn(self, scene: Scene, seconds: float) -> None:
        self._pace.append(seconds / process_seconds(scene))


def process_seconds(scene: Scene) -> float:
    """Expected wall time of a process that runs a scene [s]."""
    return START_SECONDS + expected_seconds(scene)


def _physics(scene: Scene) -> Scene:
    """A scene without what leaves its results as they are."""
    solver = scene.solver.model_copy(update={"threads": 0, "time_limit": None})
    output = scene.output.model_copy(update={"checkpoint_every": 60.0})
    return scene.model_copy(update={"solver": solver, "output": output})


def _spent(run: RunDirectory) -> float:
    """Wall seconds that a run took so far."""
    try:
        return open_run(run.path).cost.wall_s
    except KnotfemError:
        return 0.0
