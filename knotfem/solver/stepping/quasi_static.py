"""Quasi-static steps: loads advance only as fast as the rods can follow in equilibrium."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from knotfem.solver.stepping.controller import StepController, reached
from knotfem.solver.stepping.pace import Outcome, Pace, Trial

DRAG_RATE = 1.0
"""Rate of the numerical drag [1/s]. Only its product with the speed of the rods means anything, and that is adapted."""


@dataclass(frozen=True)
class QuasiStatic:
    """Load steps and, where equilibrium is lost, steps of overdamped motion under loads that stand still.

    Time has two parts here. Loads are functions of the time of the scene; rates are taken over a time of their own, so
    long while loads advance that drag carries next to nothing. A state in which drag carries more than the promised
    fraction of the load is not one of equilibrium: loads then stand still, and the rods move under drag, as an
    overdamped body does, until it carries less. So a jump from one branch of equilibria to another is followed at one
    value of the load, and a stable branch costs no step more than it would without drag. The scale of the drag cancels:
    it only says how long the time of rates is.

    Attributes:
        loads: how far loads advance; its times are those of the scene [s].
        mass: of all rods [tonne].
        force: B/r^2 [N], by which the first step of overdamped motion is chosen.
        tolerance: largest fraction of the load that viscous terms and inertia carry in an equilibrium.
        floor: the balance itself is known no better than this [N].
        move: largest move of a node that a step aims at in which loads stand still [mm].
        slip: longest slip of a contact that it aims at [mm].
        fraction: of that allowance which drag takes where the whole mass moves by the move that is aimed at. Ten times
            as much raises the bowline's last force by 1 %, a tenth changes it by less than 0.5 %.
        easy, leap: up to so many iterations the next advance is longer by this factor, so that the small steps after a
            jump do not last.
        settle_grow: factor on the next step of overdamped motion, unless an attempt was rejected. Steps that take many
            iterations grow too: shorter ones take as many, and rods in stiff contact crept, 914 steps where 62 do.
        settle_cut: factor on a step of overdamped motion that failed.
        hurry: factor on the time of rates after a failure: where a branch of equilibria ends only drag makes a state
            beyond it unique, and shorter advances alone never get there.
        recover: by which it grows again.
        start_slowness: that of the first advance.
        still: whether loads never change: their whole time then passes in the first step.
        shortest: time of rates below which a failing step ends the run, relative to the first one.
    """

    loads: StepController
    mass: float
    force: float
    tolerance: float
    floor: float
    move: float
    slip: float
    fraction: float = 0.02
    easy: int = 3
    leap: float = 2.5
    settle_grow: float = 2.5
    settle_cut: float = 0.3
    hurry: float = 0.1
    recover: float = 4.0
    start_slowness: float = 0.01
    shortest: float = 1e-8
    still: bool = False

    @property
    def watches_balance(self) -> bool:
        """Whether loads advance depends on it."""
        return True

    @property
    def first_dt(self) -> float:
        """Time in which B/r^2 would carry the whole mass by the move that settling aims at, against the drag [s]."""
        return DRAG_RATE * self.mass * self.move / self.force

    def allowance(self, load: float) -> float:
        """What viscous terms and inertia may carry in an equilibrium [N]."""
        return max(self.tolerance * load, self.floor)

    def start(self) -> Pace:
        """Ends may have been let go or forces put on: the rods settle before loads advance."""
        return Pace(self.loads.first, settling=True, dt=self.first_dt, slowness=self.start_slowness)

    def trial(self, pace: Pace, now: float, output_times: np.ndarray) -> Trial | None:
        """The next step to try."""
        if pace.settling and not (self.still and not reached(now, output_times)):
            return Trial(0.0, False, pace.dt)
        if pace.settling:
            return Trial(float(output_times[-1]) - now, True, pace.dt)
        if reached(now, output_times):
            return None
        advance, at_output = self.loads.length(pace.advance, now, output_times)
        return Trial(advance, at_output, pace.dt * pace.slowness)

    def too_far(self, moved: float, trial: Trial) -> bool:
        """Whether a step that moved a node by so much is to be rejected."""
        aim = max(self.move, self.loads.move) if trial.times.loads_advance else self.move
        return moved > self.loads.most_move * aim

    def after_failure(self, pace: Pace, trial: Trial) -> Pace | None:
        """An attempt with more drag, and a smaller advance of loads."""
        shorter = self.settle_cut if pace.settling else self.hurry
        if shorter * trial.dt < self.shortest * self.first_dt:
            return None
        if pace.settling:
            return replace(pace, dt=shorter * trial.dt)
        advance = max(self.loads.cut * trial.advance, self.loads.smallest)
        return replace(pace, advance=advance, slowness=shorter * pace.slowness)

    def after_success(self, pace: Pace, trial: Trial, outcome: Outcome) -> Pace:
        """Loads go on where the rods are in equilibrium, and stand still where they are not."""
        allowance = self.allowance(outcome.load)
        balanced = outcome.carried <= allowance
        due = not balanced and (pace.due or trial.at_output)
        if not pace.settling:
            grow = self.leap if outcome.iterations <= self.easy else None
            slowness = pace.slowness if outcome.rejected else min(1.0, self.recover * pace.slowness)
            pace = replace(
                pace, advance=self.loads.next_length(pace.advance, trial.advance, outcome, grow), slowness=slowness
            )
        if balanced:
            dt = DRAG_RATE * self.mass * self.loads.move / (self.fraction * allowance)
            return replace(pace, settling=False, dt=dt, due=False)
        return replace(pace, settling=True, dt=self._settling_time(pace, trial, outcome), due=due)

    def _settling_time(self, pace: Pace, trial: Trial, outcome: Outcome) -> float:
        if not pace.settling:
            return trial.dt
        factor = 1.0 if outcome.rejected else self.settle_grow
        if outcome.moved > 0.0:
            factor = min(factor, self.move / outcome.moved)
        if outcome.slip > 0.0:
            factor = min(factor, self.slip / outcome.slip)
        return factor * trial.dt
