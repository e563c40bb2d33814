"""Runs a scene in its directory: records, saves, tells, stops and goes on."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from typing import Any, Protocol

from knotfem.errors import Interrupted, KnotfemError, NotConverged, Stopped
from knotfem.models.base import Additions, Increment
from knotfem.run.additions import names_of, require
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.run.events import PhaseDone, TimeStepDone
from knotfem.run.fingerprint import fingerprint
from knotfem.run.progress import Progress, Silent
from knotfem.run.provenance import Provenance
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import Simulation, steps_of
from knotfem.run.source import source_rods
from knotfem.run.step_report import report_of
from knotfem.run.stop import StopRequest
from knotfem.threads import threads_of

STATUS_EVERY = 2.0
"""Seconds between updates of status.json."""


class Figures(Protocol):
    """Draws the figures of a run directory."""

    def mapped(self, run: RunDirectory, recorder: Recorder) -> None:
        """The mapping is through."""
        ...

    def finished(self, run: RunDirectory) -> None:
        """The run has ended, at its goal or before."""
        ...


def drive(
    run: RunDirectory,
    goal: str,
    progress: Progress | None = None,
    *,
    additions: Additions | None = None,
    figures: Figures | None = None,
    asked: threading.Event | None = None,
) -> None:
    """Bring a run to its goal, from its last checkpoint if there is one.

    Args:
        run: its directory.
        goal: "tie" for the loose knot at rest, "pull" for all steps.
        progress: told of each step.
        additions: of the user's own; those that the run was begun with.
        figures: draws them.
        asked: set by another thread that asks to stop; signals reach a run in the main thread alone.

    Raises:
        KnotfemError: with the exit code of what ended the run.
    """
    progress, additions = progress or Silent(), additions or Additions()
    run.check_scene()
    if _finished(run, goal):
        progress.message("nothing is left to do")
        return
    provenance, names = Provenance(run.path), names_of(additions)
    begun = run.checkpoints.metadata().get("additions") if provenance.damaged else provenance.additions
    if begun is not None and run.checkpoints.paths():
        require(begun, names, run.path, same=True)
    _tell_of_last_session(run, provenance, progress)
    with StopRequest(run.scene.solver.time_limit, asked) as stop:
        provenance.begin(threads=threads_of(run.scene), additions=names)
        driver = None
        try:
            run.write_status("running", goal=goal)
            progress.message("building the model (kernels are compiled on the first run of an installation)")
            simulation = _simulation(run, goal, additions, progress, stop)
            driver = Driver(run, simulation, progress, provenance, figures)
            driver.go()
            driver.finish()
            run.write_status("done", goal=goal, **driver.where())
            provenance.finish("done")
        except BaseException as error:
            _record(error, run, goal, driver, provenance)
            raise


def _tell_of_last_session(run: RunDirectory, provenance: Provenance, progress: Progress) -> None:
    """Say what the last session has left in disorder."""
    status = run.status
    if not status and (run.path / "status.json").exists():
        progress.message("status.json is damaged; it is written anew")
    elif "reason" in status and "exit_code" not in status:
        progress.message(f"the last session did not end in order: {status['reason']}")
    if provenance.damaged:
        progress.message("provenance.json is damaged; it is set aside, what it said of earlier sessions is lost")


def goal_of(run: RunDirectory) -> str:
    """What a run was asked for last."""
    return str(run.status.get("goal") or run.checkpoints.metadata().get("goal") or "pull")


def _finished(run: RunDirectory, goal: str) -> bool:
    """Whether a run has taken all steps that are asked for and said so."""
    status = run.status
    if (status.get("state"), status.get("goal")) != ("done", goal):
        return False
    checkpoint = run.checkpoints.latest()
    if checkpoint is None:
        return False
    return not checkpoint.metadata["inside"] and checkpoint.metadata["next_step"] >= len(steps_of(run.scene, goal))


def _simulation(
    run: RunDirectory, goal: str, additions: Additions, progress: Progress, stop: StopRequest
) -> Simulation:
    """The simulation of a run, at its beginning."""

    def heed_stop() -> None:
        if stop.due:
            kept = () if simulation.mapped else ("the mapping is computed anew by knotfem resume",)
            raise stop.error(*kept)

    simulation = Simulation(
        run.scene,
        goal,
        additions=additions,
        source=source_rods(run.scene, run.path),
        interrupt=heed_stop,
        notify=progress.message,
    )
    return simulation


def _record(error: BaseException, run: RunDirectory, goal: str, driver: Driver | None, provenance: Provenance) -> None:
    """Write what ended a session; what fails meanwhile (the disk may be full) must not hide it."""
    state = "stopped" if isinstance(error, Stopped | Interrupted | KeyboardInterrupt) else "failed"
    reason, code = (str(error), error.exit_code) if isinstance(error, KnotfemError) else (repr(error), 1)
    if isinstance(error, KeyboardInterrupt):
        reason, code = "interrupted at once; what came after the last checkpoint is lost", Interrupted.exit_code
    if driver is not None:
        with suppress(Exception):
            driver.finish()
    with suppress(Exception):
        where = driver.where() if driver is not None else {}
        run.write_status(state, goal=goal, reason=reason, exit_code=code, **where)
    with suppress(Exception):
        provenance.finish(f"{state}: {reason}")
    if driver is not None and not isinstance(error, KeyboardInterrupt):
        with suppress(Exception):
            driver.draw()


class Driver:
    """One session of a run.

    Args:
        run: its directory.
        simulation: of its scene, at its beginning.
        progress: told of each step.
        provenance: of the session.
        figures: draws them.
    """

    def __init__(
        self,
        run: RunDirectory,
        simulation: Simulation,
        progress: Progress,
        provenance: Provenance,
        figures: Figures | None,
    ) -> None:
        self.run, self.simulation, self.goal = run, simulation, simulation.goal
        self.progress, self.provenance, self.figures = progress, provenance, figures
        self.recorder = Recorder(simulation, DiskStore(run))
        self._fingerprint = fingerprint(run.scene)
        self._fraction: float | None = 0.0
        self._phase = simulation.phase
        self._told, self._saved = 0.0, time.monotonic()

    def where(self) -> dict[str, Any]:
        """For status.json."""
        fraction = self._fraction if self.simulation.phase == self._phase else 0.0
        known = {} if fraction is None else {"fraction": fraction}
        return {"phase": self.simulation.phase, "time_s": self.simulation.state.time, **known}

    def go(self) -> None:
        """Take all phases that are left."""
        self._restore()
        self.provenance.note(linear_solver=self.simulation.linear_solver)
        try:
            for event in self.simulation.run():
                self.recorder.record(event)
                self._follow(event)
        except (NotConverged, Stopped, Interrupted):
            if self.simulation.mapped:
                self._save()
            raise
        self.draw()

    def draw(self) -> None:
        """Draw the figures of what there is."""
        if self.figures is not None:
            with self.recorder.summary.output():
                self.figures.finished(self.run)

    def finish(self) -> None:
        """Write what there is to say of the run so far."""
        self.run.write_summary(self.recorder.finish())

    def _follow(self, event: Increment | TimeStepDone | PhaseDone) -> None:
        if isinstance(event, PhaseDone):
            self._phase_done(event)
            return
        self.progress.step(report_of(event))
        self._phase = self.simulation.phase
        if isinstance(event, Increment):
            self._fraction = event.mapping_time
            return
        self._fraction = None if event.fraction != event.fraction else event.fraction
        self._tell_status(event)
        if not event.last and time.monotonic() - self._saved > self.run.scene.output.checkpoint_every:
            self._save()

    def _phase_done(self, event: PhaseDone) -> None:
        if event.name == "mapping":
            tie = [path.describe() for path in self.simulation.paths]
            self.provenance.note(tie=tie)
            if self.figures is not None:
                with self.recorder.summary.output():
                    self.figures.mapped(self.run, self.recorder)
        self._save(TIED if event.tied else "")

    def _tell_status(self, event: TimeStepDone) -> None:
        """Keep status.json up to date, once in a while."""
        if time.monotonic() - self._told > STATUS_EVERY:
            self._told = time.monotonic()
            figures = {"displacement_mm": event.displacement, "force_N": event.force}
            self.run.write_status("running", goal=self.goal, **self.where(), **figures)

    def _save(self, name: str = "") -> None:
        with self.recorder.summary.output():
            checkpoint = self.recorder.checkpoint()
            metadata = {
                "goal": self.goal,
                "next_step": self.simulation.next_step,
                "inside": self.simulation.inside,
                "rows": checkpoint.rows,
                "fingerprint": self._fingerprint,
                "additions": self.provenance.additions,
            }
            self.run.checkpoints.save(checkpoint.state, metadata, name)
        self._saved = time.monotonic()

    def _restore(self) -> None:
        latest = self.run.checkpoints.latest()
        if latest is None:
            self.recorder.begin()
            return
        checkpoint = RunCheckpoint.of(latest)
        self.recorder.begin(checkpoint)
        self.simulation.restore(checkpoint.simulation)
        for path in latest.damaged:
            self.progress.message(f"{path} is damaged and removed; the run goes on from {latest.path.name}")
            path.unlink(missing_ok=True)
