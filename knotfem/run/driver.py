"""Runs a scene: mapping, relaxing, loading; saves, watches, stops and goes on."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from typing import Any

import numpy as np

from knotfem.energy.account import Balance
from knotfem.errors import Interrupted, KnotfemError, KnotLost, NotConverged, Stopped
from knotfem.models.base import make_simulation
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.monitor import KnotWatch
from knotfem.run.outputs import Outputs
from knotfem.run.progress import Progress, Silent, StepReport
from knotfem.run.provenance import Provenance
from knotfem.run.stepping import AtRest, Underway, march_of, restored_progress, stored_progress, threads_of
from knotfem.run.stop import StopRequest
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded, Pull, Relax, Release, Step
from knotfem.solver.stepping import integrator as march
from knotfem.solver.system import System, labelled
from knotfem.solver.term import Motion

STATUS_EVERY = 2.0
"""Seconds between updates of status.json."""


def tie(scene: Scene, run: RunDirectory, progress: Progress | None = None) -> None:
    """Map the centreline into the knot and let the loose knot come to rest.

    Args:
        scene: what to run.
        run: a new run, or one whose tying was stopped.
        progress: told of each step.

    Raises:
        KnotfemError: with the exit code of what ended the run.
    """
    _drive(scene, run, "tie", progress)


def pull(scene: Scene, run: RunDirectory, progress: Progress | None = None) -> None:
    """Tie if need be, then take all steps of the scene; see `tie`."""
    _drive(scene, run, "pull", progress)


def resume(run: RunDirectory, progress: Progress | None = None) -> None:
    """Go on from the last checkpoint to what the run was asked for; see `tie`."""
    checkpoint = run.checkpoints.latest()
    goal = run.read_status().get("goal") if (run.path / "status.json").exists() else None
    _drive(run.scene, run, str(goal or (checkpoint.metadata["goal"] if checkpoint else "pull")), progress)


def _drive(scene: Scene, run: RunDirectory, goal: str, progress: Progress | None) -> None:
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
            driver = Driver(scene, run, goal, progress, stop, provenance)
            driver.go()
            driver.finish()
            run.write_status("done", goal=goal, **driver.where())
            provenance.finish("done")
        except BaseException as error:
            _record(error, run, goal, driver, provenance)
            raise


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
    """Steps that a goal asks for."""
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
    ) -> None:
        self.run, self.scene, self.goal = run, scene, goal
        self.progress, self.stop, self.provenance = progress, stop, provenance
        progress.message("building the model (kernels are compiled on the first run of an installation)")
        self.model = make_simulation(self.scene, run.path)
        for warning in self.model.warnings:
            progress.message(f"warning: {warning}")
        self.account = self.model.account()
        self.watch = KnotWatch(self.model)
        self.outputs = Outputs(run, self.model)
        self.motion = self.model.straight()
        self.phase = "mapping"
        self.next_step = 0
        self.knots_before: dict[str, Any] | None = None
        self._resume_state: dict[str, Any] | None = None
        self._fraction = 0.0
        self._told = 0.0

    def where(self) -> dict[str, Any]:
        """For status.json."""
        known = {} if math.isnan(self._fraction) else {"fraction": self._fraction}
        return {"phase": self.phase, "time_s": self.motion.time, **known}

    def go(self) -> None:
        """Take all phases that are left."""
        if not self._restore():
            self._map()
        wanted = _wanted(self.scene, self.goal)
        tying = len(self.scene.tying_steps)
        if self.next_step == tying:
            self._mark_tied()
        while self.next_step < len(wanted):
            self._take(wanted[self.next_step])
            self.next_step += 1
            self._resume_state = None
            if self.next_step == tying:
                self._mark_tied()
            else:
                self._save()
        self.outputs.plots()

    def finish(self) -> None:
        """Write what there is to say of the run so far."""
        if self.knots_before is not None:
            self.outputs.summary.knots(self.knots_before, self.watch.name(self.motion.x))
        self.outputs.close(self.account)

    def _map(self) -> None:
        self.outputs.summary.begin_phase("mapping")
        paths = self.model.paths()
        solver = self.outputs.summary.choose_solver(self.scene)
        self.provenance.note(linear_solver=solver, tie=[path.describe() for path in paths])
        stretches = []
        for increment in self.model.mapping(paths, solver):
            self.outputs.summary.book(increment.system)
            self.outputs.mapping(increment)
            stretches.append(increment.stretch)
            self._fraction = increment.mapping_time
            self.motion = Motion.at_rest(increment.x)
            self.progress.step(
                StepReport("mapping", increment.mapping_time, increment.mapping_time, iterations=increment.iterations)
            )
            if not increment.solved:
                self.progress.message(
                    f"no solid can follow the mapping at time {increment.mapping_time:g}; passed over"
                )
            self.run.log(
                phase="mapping",
                mapping_time=increment.mapping_time,
                smallest_j=increment.smallest_j,
                solved=increment.solved,
            )
            self._heed_stop("the mapping is taken anew by knotfem resume")
        self.outputs.summary.stretch(stretches)
        self.outputs.stretch_plot(stretches)
        self.knots_before = self.watch.name(self.motion.x)
        self._save()

    def _take(self, step: Step) -> None:
        self.outputs.summary.begin_phase(step.name)
        self.phase, resumed, self._fraction = step.name, self._resume_state, 0.0
        underway = Underway.restored(step, resumed) if resumed else self._begun(step)
        began, origin, progress = underway.began, underway.origin, underway.progress
        equations = self.model.equations(step, began, origin, underway.before, progress)
        system = equations.system
        if resumed:
            system.restore(resumed["history"])
            self.account.restore(resumed["account"])
        else:
            system.update(self.motion.x)
            anew = self.next_step <= len(self.scene.tying_steps)
            self.account.open(self.motion.x, self.motion.v, anew=anew)
        walk = march_of(self.model, step, system, progress, began)
        walk.interrupt = self._heed_stop
        rest = AtRest(step, self.model, began) if isinstance(step, Relax | Release) else None
        saved = time.monotonic()
        try:
            for accepted in walk:
                self.motion = accepted.motion
                if self.scene.contact.enabled:
                    self.watch.check_passage(accepted.start.motion.x, self.motion.x, self.motion.time)
                balance = self.account.book(equations, accepted.start, self.motion.x, self.motion.v, origin)
                resting = rest is not None and rest.reached(self.motion.time, self.account.energies, balance)
                self._fraction = float("nan") if rest is not None else _fraction(walk, began, self.motion.time)
                self.outputs.step(step, accepted, balance, self.account, system)
                self._report(step, accepted, balance, began)
                self._tell_status(balance)
                done = resting or self.motion.time >= walk.stops[-1] * (1.0 - 1e-12)
                lost = False
                if accepted.arrived or done:
                    self.outputs.state(self.motion, balance, step)
                    lost = self._lost(step)
                if resting or (lost and isinstance(step, Release)):
                    break
                self._heed_stop()
                if not done and time.monotonic() - saved > self.scene.output.checkpoint_every:
                    self._save(underway, system)
                    saved = time.monotonic()
            else:
                if isinstance(step, Relax):
                    raise NotConverged(f"{step.name}: not at rest after {step.longest:g} s")
        except (NotConverged, Stopped, Interrupted):
            self._save(underway, system)
            raise
        finally:
            self.outputs.summary.book(system)
            system.close()

    def _heed_stop(self, *kept: str) -> None:
        if self.stop.due:
            raise self.stop.error(*kept)

    def _tell_status(self, balance: Balance) -> None:
        """Keep status.json up to date, once in a while."""
        if time.monotonic() - self._told > STATUS_EVERY:
            self._told = time.monotonic()
            figures = {"displacement_mm": balance.displacement, "force_N": balance.force}
            self.run.write_status("running", goal=self.goal, **self.where(), **figures)

    def _report(self, step: Step, accepted: march.Accepted, balance: Balance, began: float) -> None:
        self.progress.step(
            StepReport(
                step.name,
                self._fraction,
                self.motion.time - began,
                balance.displacement,
                balance.force,
                accepted.start.dt * (step.speed if isinstance(step, Pull) else 1.0),
                balance.contacts,
                balance.penetration,
                accepted.took.count,
            )
        )

    def _begun(self, step: Step) -> Underway:
        start = self.motion
        return Underway(step, start.time, start.x.copy(), self._forces_before(step), march.Progress.at(start))

    def _forces_before(self, step: Step) -> dict[str, np.ndarray]:
        """Force on each end that a coming step loads, where there was one."""
        ends = {f"{rod}.{side}" for (rod, side), end in step.all_ends().items() if isinstance(end, Loaded)}
        return {label: np.array(force) for label, force in self.account.end_forces.items() if label in ends}

    def _lost(self, step: Step) -> bool:
        """Whether a knot has come undone: an error in a step that must hold, of interest besides in a release."""
        watched = self.scene.contact.enabled and (step.must_hold or isinstance(step, Release))
        if self.knots_before is None or not watched:
            return False
        message = self.watch.lost(self.knots_before, self.watch.name(self.motion.x))
        if not message:
            return False
        if step.must_hold:
            raise KnotLost(f"{step.name}: {message}")
        self.progress.message(f"{step.name}: {message}")
        return True

    def _mark_tied(self) -> None:
        if self.run.checkpoints.named(TIED) is None:
            self._save(name=TIED)

    def _save(self, underway: Underway | None = None, system: System | None = None, name: str = "") -> None:
        self.outputs.summary.book(system)
        with self.outputs.summary.output():
            self._save_checkpoint(underway, system, name)

    def _save_checkpoint(self, underway: Underway | None, system: System | None, name: str) -> None:
        history = {label: effect.history() for label, effect in labelled(self.model.effects)}
        between = {"progress": stored_progress(march.Progress.at(self.motion))}
        state = {
            **(between if underway is None else underway.stored()),
            "history": system.history() if system is not None else history,
            "account": self.account.state(),
            "model": self.model.state(inside=underway is not None),
            "knots_before": self.knots_before,
            "outputs": self.outputs.state_for_checkpoint(),
        }
        metadata = {
            "goal": self.goal,
            "next_step": self.next_step,
            "inside": "" if underway is None else underway.step.name,
            **self.outputs.rows(),
        }
        self.run.checkpoints.save(state, metadata, name)

    def _restore(self) -> bool:
        checkpoint = self.run.checkpoints.latest()
        if checkpoint is None:
            self.outputs.begin(None)
            return False
        state = checkpoint.state
        self.outputs.begin(checkpoint.metadata)
        self.outputs.restore(state["outputs"])
        self.next_step = int(checkpoint.metadata["next_step"])
        self.knots_before = state["knots_before"]
        progress = restored_progress(state)
        self.motion = progress.motion
        for label, effect in labelled(self.model.effects):
            if label in state["history"]:
                effect.load(state["history"][label])
        self.account.restore(state["account"])
        self.model.restore(state["model"])
        if checkpoint.metadata["inside"]:
            self._resume_state = state
        self.provenance.note(linear_solver=self.outputs.summary.choose_solver(self.scene))
        return True


def _fraction(walk: march.March, began: float, now: float) -> float:
    length = float(walk.stops[-1]) - began
    return (now - began) / length if length > 0.0 else 1.0
