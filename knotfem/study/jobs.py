"""Runs of variants of a scene on the engine: cheapest first, within a budget, resumable."""

from __future__ import annotations

import logging
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from knotfem.errors import InputError
from knotfem.run.directory import RunDirectory
from knotfem.run.expected import Expected, expected
from knotfem.scene.model import Scene
from knotfem.study.engine.engine import Ended, Engine, Job
from knotfem.study.engine.outcomes import Outcome, known_outcome, spent
from knotfem.study.engine.places import Place
from knotfem.study.refinement import BASE, Level

LOG = logging.getLogger("knotfem")
OUTPUT_SECONDS = 1.0
"""Of a run, beside what is expected of its computation."""


class Workers(Protocol):
    """What `Jobs` asks of the engine."""

    @property
    def busy(self) -> bool:
        """See `Engine.busy`."""
        ...

    @property
    def free(self) -> int:
        """See `Engine.free`."""
        ...

    def submit(self, job: Job, *, priority: float = 0.0) -> None:
        """See `Engine.submit`."""
        ...

    def wait(self) -> Ended | None:
        """See `Engine.wait`."""
        ...


@dataclass(eq=False)
class Jobs:
    """Runs of the refinement levels of one scene, in one folder.

    Args:
        folder: run directories go to its subfolder runs.
        scene_of: the scene of a level.
        place: where runs are computed.
        deadline: on the clock of `time.monotonic`, or none.
        tell: told what starts, ends and is left out.
    """

    folder: Path
    scene_of: Callable[[Level], Scene]
    place: Place
    deadline: float = float("inf")
    tell: Callable[[str], None] = LOG.info
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    _pace: list[float] = field(default_factory=list)
    _takes: dict[str, Expected] = field(default_factory=dict)

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
        waiting.sort(key=lambda level: (level.name != BASE, self._seconds(level), level.name))
        if waiting:
            with Engine(self.folder, self.place, tell=self.tell) as engine:
                self.work(engine, waiting)

    def work(self, engine: Workers, waiting: list[Level]) -> None:
        """Hand out levels in their order, as far as workers and budget allow, and take note of what they came to."""
        levels = {level.name: level for level in waiting}
        while waiting or engine.busy:
            while waiting and engine.free:
                level = waiting.pop(0)
                if self._fits(level):
                    engine.submit(self._job(level))
            ended = engine.wait() if engine.busy else None
            if ended is not None:
                self._ended(levels[ended.job.name], ended)

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
        outcome = known_outcome(run, scene)
        if outcome is None:
            return False
        self.outcomes[level.name] = outcome
        if outcome.state == "done":
            self._learn(level, OUTPUT_SECONDS + spent(run))
        self.tell(f"{level.name}: {outcome.state} already")
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

    def expected(self, level: Level) -> float:
        """Wall seconds that a level still needs, by the pace of those that are done."""
        needed = self._seconds(level) * (statistics.median(self._pace) if self._pace else 1.0)
        return max(needed - spent(self.run_of(level)), 0.1 * needed)

    def _job(self, level: Level) -> Job:
        run, scene = self.run_of(level), self.scene_of(level)
        limit = None if self.deadline == float("inf") else max(self.deadline - time.monotonic(), 1.0)
        return Job(level.name, run, scene, time_limit=limit, memory_mb=self._takes_of(level).memory_mb)

    def _ended(self, level: Level, ended: Ended) -> None:
        outcome = self.outcomes[level.name] = ended.outcome
        run = self.run_of(level)
        if outcome.state == "done":
            self._learn(level, OUTPUT_SECONDS + spent(run))
        why = f", {outcome.reason}" if outcome.reason else ""
        self.tell(f"{level.name}: {outcome.state} after {ended.wall_s:.0f} s{why}")

    def _learn(self, level: Level, seconds: float) -> None:
        self._pace.append(seconds / self._seconds(level))

    def _seconds(self, level: Level) -> float:
        """Expected wall time of a level's run [s]."""
        return OUTPUT_SECONDS + self._takes_of(level).seconds

    def _takes_of(self, level: Level) -> Expected:
        """What a level's run is expected to take, found out once."""
        if level.name not in self._takes:
            self._takes[level.name] = expected(self.scene_of(level))
        return self._takes[level.name]
