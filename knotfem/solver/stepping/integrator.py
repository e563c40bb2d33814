"""Integration in time: accepted states in, accepted states out; a rejected step is dropped."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from knotfem.errors import NotConverged
from knotfem.solver.nonlinear.newton import Interrupt, Newton, Solution, StepFailed
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.state import State, longest_move
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.system import System


@dataclass(frozen=True, eq=False)
class Continuation:
    """All that the integration needs to go on.

    Attributes:
        state: accepted.
        increment: last accepted move [mm], shape [nodes, width].
        increment_dt: length of the step of that move [s], 0 where there is none to extrapolate.
        dt: length wanted of the next step [s], 0 for the controller's first.
        damping: Levenberg-Marquardt damping to begin with [N/mm].
    """

    state: State
    increment: np.ndarray
    increment_dt: float = 0.0
    dt: float = 0.0
    damping: float = 0.0

    @classmethod
    def at(cls, state: State) -> Continuation:
        """At the beginning."""
        return cls(state, np.zeros_like(state.x))


@dataclass(frozen=True, eq=False)
class AcceptedStep:
    """An accepted step.

    Attributes:
        start: the state it set out from.
        after: how to go on, with the state it ended at.
        dt: its length [s].
        solution: of Newton's method.
        rejected: attempts that were rejected before.
        failure: why the last of them was; "" for none.
        wall: seconds, rejected attempts included.
        at_output: whether it ended exactly at an output time.
    """

    start: State
    after: Continuation
    dt: float
    solution: Solution
    rejected: int
    failure: str
    wall: float
    at_output: bool

    @property
    def state(self) -> State:
        """The state that it ended at."""
        return self.after.state


def integrate(
    system: System,
    start: Continuation,
    controller: StepController,
    newton: Newton,
    sections: Sections,
    output_times: np.ndarray,
    interrupt: Interrupt | None = None,
) -> Iterator[AcceptedStep]:
    """Yield accepted steps up to the last output time.

    Args:
        system: equations.
        start: where to set out.
        controller: of the length of steps.
        newton: solver of a step.
        sections: over which resultants are summed.
        output_times: ascending [s]; they are met exactly.
        interrupt: called before each Newton iteration; what it raises ends the integration as if the step had never
                begun.

    Raises:
        NotConverged: the smallest step failed.
    """
    now = start if start.dt > 0.0 else replace(start, dt=controller.first)
    end = float(output_times[-1])
    while now.state.time < end - 1e-12 * max(1.0, abs(end)):
        step = advance(system, now, controller, newton, sections, output_times, interrupt)
        now = step.after
        yield step


def advance(
    system: System,
    now: Continuation,
    controller: StepController,
    newton: Newton,
    sections: Sections,
    output_times: np.ndarray,
    interrupt: Interrupt | None = None,
) -> AcceptedStep:
    """Take one step, shorter and shorter until it is accepted; see `integrate`."""
    began, state = time.perf_counter(), now.state
    rejected, failure = 0, ""
    trial = now
    while True:
        dt, at_output = controller.length(trial.dt, state.time, output_times)
        try:
            solution, after = _attempt(system, trial, dt, controller, newton, sections, interrupt)
            break
        except (StepFailed, ZeroDivisionError) as error:
            failure = "strands or nodes lie on each other" if isinstance(error, ZeroDivisionError) else str(error)
            rejected += 1
            shorter = controller.after_failure(dt)
            if shorter is None:
                raise NotConverged(
                    f"no balance at time {state.time:.6g} s with the smallest step {dt:.3g} s: {failure}"
                ) from error
            trial = replace(
                trial,
                dt=shorter,
                damping=max(trial.damping, newton.damping.start),
                increment_dt=0.0 if rejected > 2 else trial.increment_dt,
            )
    moved = longest_move(solution.x - state.x)
    wanted = controller.after_success(dt, trial.dt, solution.iterations, moved, rejected)
    going_on = Continuation(after, solution.x - state.x, dt, wanted, solution.damping)
    return AcceptedStep(state, going_on, dt, solution, rejected, failure, time.perf_counter() - began, at_output)


def _attempt(
    system: System,
    trial: Continuation,
    dt: float,
    controller: StepController,
    newton: Newton,
    sections: Sections,
    interrupt: Interrupt | None,
) -> tuple[Solution, State]:
    state = trial.state
    step = system.begin(state, dt)
    x = state.x
    if trial.increment_dt > 0.0:
        move = trial.increment * (dt / trial.increment_dt)
        x = x + system.allowed_fraction(x, move) * move
    solution = newton.solve(system, x, step, sections, trial.damping, interrupt)
    moved = longest_move(solution.x - state.x)
    if controller.too_far(moved, dt):
        raise StepFailed(f"a node moved by {moved:.3g} mm in one step")
    return solution, system.commit(solution.x, step)
