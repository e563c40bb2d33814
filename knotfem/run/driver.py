"""Runs a scene in its directory: records, saves, tells, stops and goes on."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import Any, Protocol

from knotfem.errors import Interrupted, KnotfemError, NotConverged, Stopped
from knotfem.models.base import Additions, Increment
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.run.progress import Progress, Silent
from knotfem.run.provenance import Provenance
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import PhaseDone, Simulation, TimeStepDone
from knotfem.run.source import source_rods
from knotfem.run.step_report import report_of
from knotfem.run.stop import StopRequest
from knotfem.scene.model import Scene
from knotfem.scene.steps import Step
from knotfem.threads import threads_of

STATUS_EVERY = 2.0
"""Seconds between updates of status.json."""


class Figures(Protocol):
    """Draws the figures of a run directory."""

    def mapped(self, run: RunDirectory, recorder: Recorder) -> None:
        """The mapping is through."""
        ...

    def finished(self, run: RunDirectory) -> None:
        """The run has reached its goal."""
        ...


def drive(
    scene: Scene,
    run: RunDirectory,
    goal: str,
    progress: Progress | None = None,
    *,
    additions: Additions | None = None,
    figures: Figures | None = None,
) -> None:
    """Bring a run to its goal, from its last checkpoint if there is one.

    Args:
        scene: what to run.
        run: its directory.
        goal: "tie" for the loose knot at rest, "pull" for all steps.
        progress: told of each step.
        additions: of the user's own.
        figures: draws them.

    Raises:
        KnotfemError: with the exit code of what ended the run.
    """
    progress = progress or Silent()
    if _finished(scene, run, goal):
        progress.message("nothing is left to do")
        return
    with StopRequest(scene.solver.time_limit) as stop:
        provenance = Provenance(run.path)
        provenance.begin(threads=threads_of(scene))
        driver = None
        try:
            run.write_status("running", goal=goal)
            driver = Driver(scene, run, goal, progress, stop, provenance, additions, figures)
            driver.go()
            driver.finish()
            run.write_status("done", goal=goal, **driver.where())
            provenance.finish("done")
        except BaseException as error:
            _record(error, run, goal, driver, provenance)
            raise


def goal_of(run: RunDirectory) -> str:
    """What a run was asked for last."""
    checkpoint = run.checkpoints.latest()
    goal = run.read_status().get("goal") if (run.path / "status.json").exists() else None
    return str(goal or (checkpoint.metadata["goal"] if checkpoint else "pull"))


def _finished(scene: Scene, run: RunDirectory, goal: str) -> bool:
    """Whether a run has taken all steps that are asked for and said so."""
    status = run.read_status() if (run.path / "status.json").exists() else {}
    if status.get("state") != "done" or status.get("goal") != goal:
        return False
    checkpoint = run.checkpoints.latest()
    if checkpoint is None:
        return False
    return not checkpoint.metadata["inside"] and int(checkpoint.metadata["next_step"]) >= len(_wanted(scene, goal))


def _wanted(scene: Scene, goal: str) -> tuple[Step, ...]:
    return scene.tying_steps if goal == "tie" else scene.steps


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


class Driver:
    """One session of a run."""

    def __init__(
        self,
        scene: Scene,
        run: RunDirectory,
        goal: str,
        progress: Progress,
        stop: StopRequest,
        provenance: Provenance,
        additions: Additions | None,
        figures: Figures | None,
    ) -> None:
        self.run, self.scene, self.goal = run, scene, goal
        self.progress, self.stop, self.provenance, self.figures = progress, stop, provenance, figures
        progress.message("building the model (kernels are compiled on the first run of an installation)")
        self.simulation = Simulation(
            scene,
            goal,
            additions=additions,
            source=source_rods(scene, run.path) if scene.tie.source is not None else None,
            interrupt=self._heed_stop,
            notify=progress.message,
        )
        self.recorder = Recorder(self.simulation, DiskStore(run))
        self._fraction: float | None = 0.0
        self._told, self._saved = 0.0, time.monotonic()

    def where(self) -> dict[str, Any]:
        """For status.json."""
        known = {} if self._fraction is None else {"fraction": self._fraction}
        return {"phase": self.simulation.phase, "time_s": self.simulation.state.time, **known}

    def go(self) -> None:
        """Take all phases that are left."""
        self._restore()
        self.provenance.note(linear_solver=self.simulation.linear_solver)
        if self.simulation.next_step == len(self.scene.tying_steps) and self.run.checkpoints.latest() is not None:
            self._mark_tied()
        try:
            for event in self.simulation.run():
                self.recorder.record(event)
                self._follow(event)
        except (NotConverged, Stopped, Interrupted):
            if self.simulation.mapped:
                self._save()
            raise
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
        if isinstance(event, Increment):
            self._fraction = event.mapping_time
            return
        self._fraction = None if event.fraction != event.fraction else event.fraction
        self._tell_status(event)
        if not event.last and time.monotonic() - self._saved > self.scene.output.checkpoint_every:
            self._save()

    def _phase_done(self, event: PhaseDone) -> None:
        if event.name == "mapping":
            tie = [path.describe() for path in self.simulation.paths]
            self.provenance.note(tie=tie)
            if self.figures is not None:
                with self.recorder.summary.output():
                    self.figures.mapped(self.run, self.recorder)
            self._save()
        if event.tied:
            self._mark_tied()
        elif event.name != "mapping":
            self._save()

    def _heed_stop(self) -> None:
        if self.stop.due:
            mapped = self.simulation.mapped
            raise self.stop.error(*(() if mapped else ("the mapping is computed anew by knotfem resume",)))

    def _tell_status(self, event: TimeStepDone) -> None:
        """Keep status.json up to date, once in a while."""
        if time.monotonic() - self._told > STATUS_EVERY:
            self._told = time.monotonic()
            figures = {"displacement_mm": event.displacement, "force_N": event.force}
            self.run.write_status("running", goal=self.goal, **self.where(), **figures)

    def _mark_tied(self) -> None:
        if self.run.checkpoints.named(TIED) is None:
            self._save(TIED)

    def _save(self, name: str = "") -> None:
        with self.recorder.summary.output():
            checkpoint = self.recorder.checkpoint()
            metadata = {
                "goal": self.goal,
                "next_step": self.simulation.next_step,
                "inside": self.simulation.inside,
                "rows": checkpoint.rows,
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
