"""A scene in memory: mapping, relaxing, loading, one accepted step after the other; no files, no screen."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from knotfem.energy.balance import EnergyBalance, StepFigures
from knotfem.errors import KnotLost, NotConverged
from knotfem.models.base import Additions, Equations, Model
from knotfem.models.build import build_model
from knotfem.models.newton import newton_of
from knotfem.models.rod.initial import SourceRod
from knotfem.run.events import Event, PhaseDone, TimeStepDone
from knotfem.run.expected import refuse_too_large
from knotfem.run.jumps import JumpWatch
from knotfem.run.knot_words import Knots
from knotfem.run.monitor import KnotMonitor, of_checkpoint
from knotfem.run.remarks import Remarks
from knotfem.run.schedule import Rest, schedule_of
from knotfem.run.underway import Underway, restored, restored_state, stored, stored_step
from knotfem.run.validity import Validity
from knotfem.run.verdict_watch import VerdictWatch
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded, Relax, Release, Step
from knotfem.solver.nonlinear.newton import Interrupt
from knotfem.solver.state import State
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.integrator import integrate
from knotfem.solver.system import System
from knotfem.sparse.linear import solver_name
from knotfem.stability.ends import deciding_steps
from knotfem.tie import CentrelinePath

LOG = logging.getLogger("knotfem")


def steps_of(scene: Scene, goal: str) -> tuple[Step, ...]:
    """Steps of a scene that a goal asks for: "tie" for those at its head that relax, "pull" for all."""
    return scene.tying_steps if goal == "tie" else scene.steps


def unheld(step: Step, scene: Scene) -> str:
    """What may be wrong where not even the first balance of a step is found, in words; empty where nobody knows."""
    relaxing = isinstance(step, Relax)
    drag = 0.0 if scene.drag is None else scene.drag.rate_of(relaxing)
    if not step.real or drag > 0.0 or scene.inertia.scheme_of(relaxing) != "quasi-static":
        return ""
    return (
        "; this step goes in real time with neither drag nor inertia, so that nothing holds rods that are loose: "
        'leave out rate = "real", or give inertia.scheme = "hht" or [drag] rate = "20 1/s"'
    )


class Simulation:
    """A scene, from the straight rods to its last step, or on from a checkpoint.

    Args:
        scene: what to run.
        goal: "tie" for the loose knot at rest, "pull" for all steps.
        additions: of the user's own.
        source: rods as another run has left them, or none.
        model: of the scene, made with what a scene cannot say, such as a cross-section of its own; None builds it.
        interrupt: called before each Newton iteration and after each step; what it raises ends the run as if the step
            had not begun.
        notify: is told what a user should know; a log by default.

    Attributes:
        model: of the scene.
        balance: of energy.
        monitor: of the knots.
        state: accepted.
        phase: name of the present one.
        wanted: steps of the scene that the goal asks for.
        next_step: number of the scene's step that comes next.
        knots_before: that the steps set out from.
        watch: gathers what tells whether the knot holds; None before the first step, and where no step shows it.
        decided: whether the verdict has ended the run before its last step.
        mapped: whether the mapping is through.
        paths: mapping of each rod, once it has begun.
        system: equations of the scene's step that is under way, or None.
        linear_solver: name of the one that is used.
        remarks: what a user should know of the run.
        validity: how far the run has come towards the limits of its model.
        decides: whether some step shows whether the knot holds.
    """

    def __init__(
        self,
        scene: Scene,
        goal: str = "pull",
        *,
        additions: Additions | None = None,
        source: Sequence[SourceRod] = (),
        model: Model | None = None,
        interrupt: Interrupt | None = None,
        notify: Callable[[str], None] = LOG.info,
    ) -> None:
        self.scene, self.goal, self.notify = scene, goal, notify
        self.interrupt = interrupt
        if model is None:
            refuse_too_large(scene)
        self.model = build_model(scene, additions, source) if model is None else model
        for warning in self.model.warnings:
            notify(f"warning: {warning}")
        self.balance = EnergyBalance(self.model)
        self.monitor = KnotMonitor(self.model)
        self.state = self.model.straight()
        self.phase = "mapping"
        self.next_step = 0
        self.wanted = steps_of(scene, goal)
        self.knots_before: Knots | None = None
        self.watch: VerdictWatch | None = None
        self.decided = False
        self.linear_solver = solver_name(scene.solver.linear)
        self.mapped = False
        self.paths: list[CentrelinePath] = []
        self._started_at: list[np.ndarray] | None = None
        self._underway: Underway | None = None
        self._displaced = self._reached = 0.0
        self.system: System | None = None
        self.remarks = Remarks(notify)
        self.validity = Validity(self.model, self.remarks)
        self.decides = scene.contact.enabled and bool(deciding_steps(self.wanted))

    def start_at(self, state: State) -> None:
        """Take the steps of the scene from this state, without a mapping.

        Args:
            state: tied rods. The ends of their centrelines, rather than those of the scene's, tell in which directions
                the rods are continued where knots are named.
        """
        self.state, self.mapped = state, True
        self._watch_from(self.model.centrelines(state.x))
        self.knots_before = self.knots()

    def _watch_from(self, centrelines: list[np.ndarray]) -> None:
        self._started_at = centrelines
        self.monitor = KnotMonitor(self.model, centrelines)

    def knots(self) -> Knots:
        """Knots of the present state."""
        return self.monitor.knots(self.state.x)

    def run(self) -> Iterator[Event]:
        """Take all phases that are left.

        Raises:
            KnotfemError: what ends a run; the state is the last accepted one.
        """
        if not self.mapped:
            yield from self._map()
        while self.next_step < len(self.wanted):
            step = self.wanted[self.next_step]
            yield from self._take(step)
            self._underway, self.system = None, None
            if self.next_step >= len(self.scene.tying_steps):
                self._displaced = max(self._displaced, self._reached)
            self._reached = self._displaced
            self.next_step += 1
            tied = self.next_step == len(self.scene.tying_steps)
            if self.decided:
                self.next_step = len(self.wanted)
            yield PhaseDone(step.name, tied)

    def _map(self) -> Iterator[Event]:
        self.paths = self.model.paths()
        for increment in self.model.mapping(self.paths, self.linear_solver):
            self.state = increment.state
            if not increment.solved:
                self.notify(f"no solid can follow the mapping at time {increment.mapping_time:g}; skipped")
            yield increment
            if self.interrupt is not None:
                self.interrupt()
        self.knots_before = self.knots()
        self.mapped = True
        yield PhaseDone("mapping", not self.scene.tying_steps)

    def _take(self, step: Step) -> Iterator[TimeStepDone]:
        resumed = self._underway
        self.phase = step.name
        underway = resumed or self._begun(step)
        equations = self.model.equations(step, underway.origin, underway.before)
        system = self.system = equations.system
        if resumed is None:
            adapted = self.model.adapted(self.state, equations)
            underway = replace(underway, now=replace(underway.now, state=adapted))
            self.balance.begin(equations, adapted, anew=self._balance_anew)
            self._watch_step(step, adapted)
        elif resumed.keys is not None:
            system.load(resumed.now.state)
            system.update(resumed.now.state.x)
            system.restore_pattern(resumed.keys)
        self._underway = underway
        try:
            yield from self._integrate(step, equations, underway)
        except NotConverged as error:
            hint = unheld(step, self.scene) if self.state.time == underway.origin.time else ""
            raise NotConverged(f"{step.name}: {error}{hint}") from error
        finally:
            system.close()

    def _integrate(self, step: Step, equations: Equations, underway: Underway) -> Iterator[TimeStepDone]:
        model, began, watch = self.model, underway.origin.time, underway.watch
        schedule = schedule_of(model, step, began)
        rest = Rest(step, model, began) if step.real and isinstance(step, Relax | Release) else None
        steps = integrate(
            equations.system,
            underway.now,
            schedule.pacing,
            newton_of(model),
            model.sections,
            schedule.output_times,
            self.interrupt,
        )
        for accepted in steps:
            self.state = accepted.state
            self._underway = replace(underway, now=accepted.after, keys=equations.system.keys)
            if self.scene.contact.enabled:
                self.monitor.check_interpenetration(accepted.start.x, self.state.x, self.state.time)
            figures = self.balance.update(equations, accepted, underway.origin)
            self._reached = self._displaced + figures.displacement
            resting = rest is not None and rest.reached(self.state.time, self.balance.energies, figures)
            last = resting or (accepted.at_output and schedule.over(self.state.time))
            jump = watch.update(step.name, accepted, figures, self.balance.energies, self._displaced)
            if jump is not None and step.loading:
                self.notify(f"{step.name}: {jump}")
            equilibrium = schedule.in_equilibrium(accepted, figures)
            self._judge(
                step, figures, settled=equilibrium, at_rest=resting or (last and equilibrium), output=accepted.at_output
            )
            slipped = self.watch is not None and self.watch.slipped
            last = last or self.decided or slipped
            if last or (accepted.at_output and step.loading):
                self.validity.look(step, self.state.x, figures.penetration, self.state.time, self._reached)
            yield TimeStepDone(
                step,
                accepted,
                figures,
                self.balance.energies,
                equations.system,
                elapsed=self.state.time - began,
                fraction=float("nan") if rest is not None else schedule.fraction(began, self.state.time),
                output=accepted.at_output or last,
                last=last,
                equilibrium=equilibrium,
                jump=jump,
                before=self._displaced,
                drawn_in=0.0 if self.watch is None else self.watch.drawn_in,
            )
            if self.decided:
                self._end_decided(step)
                return
            lost = (accepted.at_output or last or watch.wandered(self.state.x)) and self._lost(step)
            if resting or slipped or (lost and isinstance(step, Release)):
                return
            if self.interrupt is not None:
                self.interrupt()
        if step.real and isinstance(step, Relax):
            raise NotConverged(f"not at rest after {step.longest:g} s")

    @property
    def _balance_anew(self) -> bool:
        """Whether the energy balance starts with the present step of the scene."""
        return self.next_step <= len(self.scene.tying_steps)

    def _begun(self, step: Step) -> Underway:
        ends = {f"{rod}.{side}" for (rod, side), end in step.all_ends().items() if isinstance(end, Loaded)}
        before = {label: np.array(force) for label, force in self.balance.end_forces.items() if label in ends}
        taken = 0.0 if self._balance_anew else sum(self.balance.energies.taken.values())
        watch = JumpWatch(self.model, self.state.x, taken)
        return Underway(step, self.model.origin(self.state), before, Continuation.at(self.state), watch)

    def _watch_step(self, step: Step, state: State) -> None:
        """A step of the scene begins; watch over it if some step shows whether the knot holds."""
        if self.watch is None:
            self.watch = self._new_watch()
        if self.watch is not None:
            self.watch.begin(step, state.x, state.time)

    def _new_watch(self) -> VerdictWatch | None:
        if self.knots_before is None or not self.decides:
            return None
        return VerdictWatch(self.model, self.monitor, self.knots_before)

    def _judge(self, step: Step, figures: StepFigures, *, settled: bool, at_rest: bool, output: bool) -> None:
        """Gather what the present state tells of the verdict; decide the run where the step says so."""
        if self.watch is None:
            return
        x, time = self.state.x, self.state.time
        lost = self.watch.update(step, x, figures, time, settled=settled, at_rest=at_rest, output=output)
        self.decided = bool(lost) and step.until == "decided"

    def _end_decided(self, step: Step) -> None:
        message = "" if self.watch is None else self.watch.lost
        if step.must_hold:
            raise KnotLost(f"{step.name}: {message}")
        self.notify(f"{step.name}: {message}; the run ends here")

    def verdict(self) -> dict[str, Any]:
        """Verdict, evidence and failure mode, for the summary; empty where no step shows whether the knot holds."""
        return {} if self.watch is None else self.watch.figures(self.state.x)

    def _lost(self, step: Step) -> bool:
        """Whether a knot has come undone: an error in a step that must hold, the end of a release, said otherwise."""
        if self.knots_before is None or not self.scene.contact.enabled:
            return False
        if not step.must_hold:
            for said in self.monitor.gone(self.knots_before, self.state.x, self.remarks.kept):
                self.remarks.tell(said, f"{said} at {{when}}", step, self.state.time, self._reached)
            if not isinstance(step, Release):
                return False
        message = self.monitor.lost(self.knots_before, self.state.x)
        if message and self.watch is not None:
            self.watch.note_lost(message, step, self.state.time)
        if message and step.must_hold:
            raise KnotLost(f"{step.name}: {message}")
        return bool(message)

    def checkpoint(self) -> dict[str, Any]:
        """All that is needed to go on to the same bits."""
        u = self._underway
        now = Continuation.at(self.state) if u is None else u.now
        return {
            "now": stored(now),
            "underway": None if u is None else stored_step(u),
            "balance": self.balance.state(),
            "knots_before": self.knots_before,
            "started_at": self._started_at,
            "next_step": self.next_step,
            "displaced": (self._displaced, self._reached),
            "verdict": None if self.watch is None else self.watch.state(),
            "remarks": self.remarks.kept,
            "validity": self.validity.found,
        }

    @property
    def inside(self) -> str:
        """Name of the scene's step that is under way, or ""."""
        return "" if self._underway is None else self._underway.step.name

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a checkpoint."""
        self.knots_before, self.next_step = of_checkpoint(state["knots_before"]), int(state["next_step"])
        self._displaced, self._reached = state.get("displaced", (0.0, 0.0))
        self.remarks.kept, self.validity.found = {**state.get("remarks", {})}, {**state.get("validity", {})}
        if state.get("started_at") is not None:
            self._watch_from(state["started_at"])
        now = restored(state["now"])
        self.state, self.mapped = now.state, True
        self.balance.restore(state["balance"])
        self.watch = self._new_watch() if state.get("verdict") else None
        if self.watch is not None:
            self.watch.restore(state["verdict"])
        underway = state["underway"]
        if underway is not None:
            step = self.scene.steps[self.next_step]
            origin = restored_state(underway["origin"])
            watch = JumpWatch(self.model, now.state.x)
            watch.restore(underway["watch"])
            self._underway = Underway(step, origin, underway["before"], now, watch, underway["keys"])
            self.phase = step.name
        elif self.next_step > 0:
            self.phase = self.scene.steps[self.next_step - 1].name
