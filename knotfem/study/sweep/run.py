"""The verb `sweep`: brings all points of a study to an outcome and keeps their table."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, KnotfemError, NotConverged
from knotfem.files import write_atomically, write_json
from knotfem.run.directory import RunDirectory
from knotfem.run.provenance import library_versions, timestamp
from knotfem.scene.load import Overrides
from knotfem.study.engine.engine import Ended, Engine, Job
from knotfem.study.engine.outcomes import Outcome
from knotfem.study.engine.places import Place, place_of
from knotfem.study.progress import StudyProgress, Tally, study_progress
from knotfem.study.sweep.collect import JUDGED, collect
from knotfem.study.sweep.plan import Planned, plan
from knotfem.study.sweep.study_file import STUDY_FILE, Study, read_study, study_text
from knotfem.study.sweep.table import StudyTable, table_of

STATUS_FILE = "study.json"
WRITE_EVERY = 5.0
"""Seconds between updates of table and status."""
WAITING = "waiting"
"""State of a point without an outcome."""


def sweep(
    study: str | Path | Mapping[str, Any],
    overrides: Overrides = (),
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    cluster: str | Path | None = None,
    progress: StudyProgress | bool = True,
) -> StudyTable:
    """Run a scene at every combination of axes, and collect what came of it.

    Points that have a result in the folder keep it, interrupted ones go on from their checkpoints, so that the same
    call goes on with a study that was stopped or killed. A point that fails is a result, with its reason. By default
    there are as many processes as processors, each with one run at a time; a script must call this under
    `if __name__ == "__main__":`, since these processes import it.

    Args:
        study: a TOML file, the folder of a study, or the tables of such a file.
        overrides: changes of scene keys for all points.
        out: folder of the results; studies/NAME by default.
        jobs: runs at a time on this machine.
        scheduler: address of a dask scheduler that runs already, such as "tcp://host:8786".
        cluster: TOML file that says what to ask a cluster's batch system for.
        progress: whether to show progress, or an object that is told.

    Returns:
        The table, which is in study.csv too.

    Raises:
        InputError: the study is wrong; all problems at once.
        NotConverged: no point could be computed.
        Stopped: by SIGTERM; all runs have written checkpoints.
        Interrupted: by Ctrl-C, likewise.
        KnotfemError: the scheduler is gone, or runs crashed.
    """
    place = place_of(jobs, scheduler, cluster)
    wanted = read_study(study, overrides)
    folder = folder_of(study, wanted, out)
    planned = plan(wanted, folder, None if isinstance(study, Mapping) else study)
    shown = study_progress(quiet=not progress) if isinstance(progress, bool) else progress
    with closing(shown):
        return Sweep(wanted, folder, planned, place, shown).run()


def estimate(
    study: str | Path | Mapping[str, Any], overrides: Overrides = (), *, out: str | Path | None, place: Place
) -> dict[str, Any]:
    """What a study would take, without running it; see `sweep` for the arguments."""
    wanted = read_study(study, overrides)
    folder = folder_of(study, wanted, out)
    planned = plan(wanted, folder, None if isinstance(study, Mapping) else study)
    left = [entry for entry in planned if entry.outcome is None]
    hours = sum(entry.seconds for entry in left) / 3600.0
    largest = sorted((entry.memory_mb for entry in left), reverse=True)[: place.slots]
    found = {
        "folder": str(folder),
        "points": len(planned),
        "runs": len(left),
        "known already": len(planned) - len(left) - sum(entry.scene is None for entry in planned),
        "no valid scene": {entry.point.name: entry.outcome.reason for entry in planned if _refused(entry)},  # pyright: ignore[reportOptionalMemberAccess]
        "runs at a time": place.slots,
        "expected_hours": _short(max(hours / place.slots, max((e.seconds for e in left), default=0.0) / 3600.0)),
        "expected_cpu_hours": _short(hours),
        "expected_memory_mb": round(sum(largest)),
        "expected_memory_mb_of_a_run": round(max(largest, default=0.0)),
    }
    script = place.job_script()
    return found if script is None else {**found, "job_script": script}


def folder_of(study: str | Path | Mapping[str, Any], wanted: Study, out: str | Path | None) -> Path:
    """Where the results go.

    Raises:
        InputError: the place is a file.
    """
    if out is not None:
        folder = Path(out)
    elif not isinstance(study, Mapping) and Path(study).is_dir():
        folder = Path(study)
    else:
        folder = Path("studies") / wanted.name
    if folder.is_file():
        raise InputError("this is a file", file=folder, expected="a folder for the study")
    return folder


@dataclass(eq=False)
class Sweep:
    """A study under way.

    Attributes:
        study: what is asked for.
        folder: of its results.
        planned: all points.
        place: where runs are computed.
        progress: told of it.
        outcomes: so far, by the point's name.
    """

    study: Study
    folder: Path
    planned: list[Planned]
    place: Place
    progress: StudyProgress
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    _figures: dict[str, dict[str, Any]] = field(default_factory=dict)
    _costs: dict[str, dict[str, Any]] = field(default_factory=dict)
    _pace: list[float] = field(default_factory=list)
    _began: str = field(default_factory=timestamp)
    _written: float = float("-inf")

    def run(self) -> StudyTable:
        """Bring all points to an outcome; see `sweep`."""
        for entry in self.planned:
            if entry.outcome is not None:
                self._keep(entry, entry.outcome)
        known = len(self.outcomes)
        if known:
            self.progress.message(f"{known} of {len(self.planned)} points have a result already")
        by_name = {entry.point.name: entry for entry in self.planned}
        with Engine(self.folder, self.place, tell=self.progress.message) as engine:
            write_atomically(self.folder / STUDY_FILE, study_text(self.study))
            self._write("running", force=True)
            try:
                for entry in self.planned:
                    if entry.outcome is None:
                        engine.submit(self._job(entry))
                while engine.busy:
                    ended = engine.wait()
                    if ended is not None:
                        self._ended(by_name[ended.job.name], ended)
                    self.progress.update(self._tally(engine))
                    self._write("running")
            except BaseException:
                self._recall()
                self._write("stopped", force=True)
                raise
            self.progress.update(self._tally(engine))
            table = self._write("done", force=True)
        self._check()
        return table

    def _job(self, entry: Planned) -> Job:
        run = entry.run
        if not RunDirectory.is_run(run.path):
            assert entry.scene is not None, "points without a scene have an outcome"
            run = RunDirectory.create(entry.scene, run.path)
        return Job(entry.point.name, run, memory_mb=entry.memory_mb)

    def _ended(self, entry: Planned, ended: Ended) -> None:
        self._costs[entry.point.name] = {"wall_s": ended.wall_s, "cpu_s": ended.cpu_s, "worker": ended.worker}
        if ended.outcome.state == "done" and entry.seconds > 0.0:
            self._pace.append(ended.wall_s / entry.seconds)
        self._keep(entry, ended.outcome)
        if ended.outcome.state == "failed":
            self.progress.message(f"{entry.point.name}: failed, {ended.outcome.reason}")

    def _keep(self, entry: Planned, outcome: Outcome) -> None:
        name = entry.point.name
        self.outcomes[name] = outcome
        self._figures[name] = collect(entry.run, self.study.collect) if entry.scene is not None else {}

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

    def _write(self, state: str, *, force: bool = False) -> StudyTable:
        """Keep table and status up to date."""
        names = ["point", *self.study.keys, "state", JUDGED[0], JUDGED[1], "reason", *self.study.collect]
        table = table_of(self.folder, (self._row(entry) for entry in self.planned), names)
        if not force and time.monotonic() - self._written < WRITE_EVERY:
            return table
        table.write()
        write_json(self.folder / STATUS_FILE, self._status(state))
        self._written = time.monotonic()
        return table

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
            "name": self.study.name,
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
            name for name in self.study.collect if all(self._figures[n].get(name) is None for n in self._figures)
        ]
        if missing:
            self.progress.message(f"no point has {', '.join(missing)}")


def _refused(entry: Planned) -> bool:
    return entry.scene is None


def _short(hours: float) -> float:
    return float(f"{hours:.2g}")
