"""The points of a study: each is brought to an outcome, and their table is kept."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, KnotfemError, NotConverged
from knotfem.files import write_atomically, write_json
from knotfem.run.directory import RunDirectory
from knotfem.run.provenance import library_versions, timestamp
from knotfem.study.engine.engine import Ended, Engine, Job
from knotfem.study.engine.outcomes import Outcome
from knotfem.study.engine.places import Place
from knotfem.study.progress import StudyProgress, Tally
from knotfem.study.sweep.collect import JUDGED, collect
from knotfem.study.sweep.plan import Planned
from knotfem.study.sweep.study_file import STUDY_FILE, Collected
from knotfem.study.sweep.table import StudyTable, table_of

STATUS_FILE = "study.json"
WRITE_EVERY = 5.0
"""Seconds between updates of table and status."""
WAITING = "waiting"
"""State of a point without an outcome."""


def folder_at(path: Path) -> Path:
    """A place for a study.

    Raises:
        InputError: it is a file.
    """
    if path.is_file():
        raise InputError("this is a file", file=path, expected="a folder for the study")
    return path


@dataclass(frozen=True)
class Asked:
    """What a study is.

    Attributes:
        name: of the study.
        keys: columns of the table with the values of its points.
        collect: figures of each run by column; see `collect`.
        text: of the file that describes it.
    """

    name: str
    keys: Sequence[str]
    collect: Mapping[str, str | Collected]
    text: str


@dataclass(eq=False)
class Points:
    """The points of a study under way.

    Attributes:
        asked: what the study is.
        folder: of its results.
        planned: all points so far.
        place: where runs are computed.
        progress: told of it.
        follow: asked for further points whenever one has ended, those that have an outcome included; or none.
        outcomes: so far, by the point's name.
    """

    asked: Asked
    folder: Path
    planned: list[Planned]
    place: Place
    progress: StudyProgress
    follow: Callable[[StudyTable], list[Planned]] | None = None
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    _by_name: dict[str, Planned] = field(default_factory=dict)
    _figures: dict[str, dict[str, Any]] = field(default_factory=dict)
    _costs: dict[str, dict[str, Any]] = field(default_factory=dict)
    _pace: list[float] = field(default_factory=list)
    _began: str = field(default_factory=timestamp)
    _written: float = float("-inf")

    def run(self) -> StudyTable:
        """Bring all points to an outcome.

        Raises:
            NotConverged: no point could be computed.
            KnotfemError: see `Engine.results`; or runs crashed.
        """
        waiting = self._add(self.planned)
        known = len(self.outcomes)
        if known:
            self.progress.message(f"{known} of {len(self.planned)} points have a result already")
        eager = self.follow is None
        with Engine(self.folder, self.place, tell=self.progress.message, eager=eager) as engine:
            write_atomically(self.folder / STUDY_FILE, self.asked.text)
            self._write("running")
            try:
                for entry in [*waiting, *self._further()]:
                    engine.submit(self._job(entry))
                while engine.busy:
                    ended = engine.wait()
                    if ended is not None:
                        self._ended(ended)
                        for entry in self._further():
                            engine.submit(self._job(entry))
                    self.progress.update(self._tally(engine))
                    self._update()
            except BaseException:
                self._recall()
                self._write("stopped")
                raise
            self.progress.update(self._tally(engine))
            table = self._write("done")
        self._check()
        return table

    def _add(self, entries: list[Planned]) -> list[Planned]:
        """Take note of points; returns those that have no outcome yet."""
        self._by_name |= {entry.point.name: entry for entry in entries}
        for entry in entries:
            if entry.outcome is not None:
                self._keep(entry, entry.outcome)
        return [entry for entry in entries if entry.outcome is None]

    def _further(self) -> list[Planned]:
        """Points that follow from those that have an outcome, to be run."""
        while self.follow is not None and (new := self.follow(self._table())):
            self.planned = [*self.planned, *new]
            if waiting := self._add(new):
                return waiting
        return []

    def _job(self, entry: Planned) -> Job:
        return Job(entry.point.name, entry.run, entry.scene, memory_mb=entry.memory_mb)

    def _ended(self, ended: Ended) -> None:
        entry = self._by_name[ended.job.name]
        self._costs[entry.point.name] = {"wall_s": ended.wall_s, "cpu_s": ended.cpu_s, "worker": ended.worker}
        if ended.outcome.state == "done" and entry.seconds > 0.0:
            self._pace.append(ended.wall_s / entry.seconds)
        self._keep(entry, ended.outcome)
        if ended.outcome.state == "failed":
            self.progress.message(f"{entry.point.name}: failed, {ended.outcome.reason}")

    def _keep(self, entry: Planned, outcome: Outcome) -> None:
        name = entry.point.name
        self.outcomes[name] = outcome
        self._figures[name] = collect(entry.run, self.asked.collect) if entry.scene is not None else {}

    def _recall(self) -> None:
        """Take note of runs that ended while the study was being stopped."""
        for entry in self.planned:
            state = entry.run.status.get("state") if RunDirectory.is_run(entry.run.path) else None
            if entry.point.name not in self.outcomes and state == "stopped":
                self.outcomes[entry.point.name] = Outcome("stopped", "the same command goes on")

    def _tally(self, engine: Engine) -> Tally:
        states = [outcome.state for outcome in self.outcomes.values()]
        left = sum(entry.seconds for entry in self.planned if entry.point.name not in self.outcomes)
        pace = statistics.median(self._pace) if self._pace else float("nan")
        running = engine.running
        return Tally(
            len(self.planned), states.count("done"), states.count("failed"), running, left * pace / max(running, 1)
        )

    def _update(self) -> None:
        """Keep table and status up to date, once in a while."""
        if time.monotonic() - self._written > WRITE_EVERY:
            self._write("running")

    def _write(self, state: str) -> StudyTable:
        """Write table and status."""
        table = self._table()
        table.write()
        write_json(self.folder / STATUS_FILE, self._status(state))
        self._written = time.monotonic()
        return table

    def _table(self) -> StudyTable:
        names = ["point", *self.asked.keys, "state", *JUDGED, "reason", *self.asked.collect]
        return table_of(self.folder, (self._row(entry) for entry in self.planned), names)

    def _row(self, entry: Planned) -> dict[str, Any]:
        name = entry.point.name
        outcome = self.outcomes.get(name)
        judged = (
            {"state": WAITING, "reason": ""} if outcome is None else {"state": outcome.state, "reason": outcome.reason}
        )
        return {"point": name, **entry.point.values, **judged, **self._figures.get(name, {})}

    def _status(self, state: str) -> dict[str, Any]:
        states = [outcome.state for outcome in self.outcomes.values()]
        counted = {name: states.count(name) for name in ("done", "failed", "stopped")}
        return {
            "state": state,
            "name": self.asked.name,
            "began": self._began,
            "updated": timestamp(),
            "pid": os.getpid(),
            "points": len(self.planned),
            **counted,
            "versions": library_versions(),
            "runs": {
                name: {"state": outcome.state, **self._costs.get(name, {})} for name, outcome in self.outcomes.items()
            },
        }

    def _check(self) -> None:
        """Raise where no point was computed, or some are no result."""
        outcomes = [self.outcomes[entry.point.name] for entry in self.planned]
        if all(outcome.state == "failed" for outcome in outcomes):
            raise NotConverged(f"no point could be computed, see {self.folder}; the first: {outcomes[0].reason}")
        crashed = [entry.point.name for entry in self.planned if not self.outcomes[entry.point.name].final]
        if crashed:
            raise KnotfemError(f"{len(crashed)} points crashed: {', '.join(crashed[:5])}; the same command tries again")
        missing = [
            name for name in self.asked.collect if all(self._figures[n].get(name) is None for n in self._figures)
        ]
        if missing:
            self.progress.message(f"no point has {', '.join(missing)}")
