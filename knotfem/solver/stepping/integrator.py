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
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.controller import reached
from knotfem.solver.stepping.pace import Outcome, Pacing, Trial
from knotfem.solver.system import System


@dataclass(frozen=True, eq=False)
class AcceptedStep:
    """An accepted step.

    Attributes:
        start: the state it set out from.
        after: how to go on, with the state it ended at.
        advance: of loads [s].
        dt: time over which rates were taken [s].
        settled: whether it ended in equilibrium, as far as the pacing asks for it.
        solution: of Newton's method.
        rejected: attempts that were rejected before.
        failure: why the last of them was; "" for none.
        wall: seconds, rejected attempts included.
        at_output: whether it ended exactly at an output time, settled.
    """

    start: State
    after: Continuation
    advance: float
    dt: float
    settled: bool
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
    pacing: Pacing,
    newton: Newton,
    sections: Sections,
    output_times: np.ndarray,
    interrupt: Interrupt | None = None,
) -> Iterator[AcceptedStep]:
    """Yield accepted steps up to the last output time.

    Args:
        system: equations.
        start: where to set out.
        pacing: decides on steps.
        newton: solver of a step.
        sections: over which resultants are summed.
        output_times: ascending [s]; they are met exactly.
        interrupt: called before each Newton iteration; what it raises ends the integration as if the step had never
                begun.

    Raises:
        NotConverged: the smallest step failed.
    """
    now = start
    while (step := advance(system, now, pacing, newton, sections, output_times, interrupt)) is not None:
        now = step.after
        yield step


def advance(
    system: System,
    now: Continuation,
    pacing: Pacing,
    newton: Newton,
    sections: Sections,
    output_times: np.ndarray,
    interrupt: Interrupt | None = None,
) -> AcceptedStep | None:
    """Take one step, smaller and smaller until it is accepted; None where there is none to take. See `integrate`."""
    began, state = time.perf_counter(), now.state
    pace = pacing.start() if now.pace is None else now.pace
    rejected, failure = 0, ""
    attempt = now
    while True:
        trial = pacing.trial(pace, state.time, output_times)
        if trial is None:
            return None
        try:
            solution, after = _attempt(system, attempt, trial, pacing, newton, sections, interrupt)
            break
        except (StepFailed, ZeroDivisionError) as error:
            failure = "strands or nodes lie on each other" if isinstance(error, ZeroDivisionError) else str(error)
            rejected += 1
            smaller = pacing.after_failure(pace, trial)
            if smaller is None:
                raise NotConverged(
                    f"no balance at time {state.time:.6g} s with the smallest step {trial.dt:.3g} s: {failure}"
                ) from error
            pace = smaller
            attempt = replace(
                attempt,
                damping=max(attempt.damping, newton.damping.start),
                dt=0.0 if rejected > 2 else attempt.dt,
            )
    outcome = _outcome(system, solution, state, rejected, sections, pacing)
    following = pacing.after_success(pace, trial, outcome)
    going_on = now.followed_by(after, trial, following, solution.damping)
    due = trial.at_output or pace.due or reached(after.time, output_times)
    at_output = due and not following.settling
    wall = time.perf_counter() - began
    return AcceptedStep(
        state, going_on, trial.advance, trial.dt, not following.settling, solution, rejected, failure, wall, at_output
    )


def _attempt(
    system: System,
    attempt: Continuation,
    trial: Trial,
    pacing: Pacing,
    newton: Newton,
    sections: Sections,
    interrupt: Interrupt | None,
) -> tuple[Solution, State]:
    state = attempt.state
    step = system.begin(state, trial.dt, None if trial.rates_over is None else trial.advance)
    x = state.x
    move = attempt.predicted(trial)
    if move is not None:
        x = x + system.allowed_fraction(x, move) * move
    solution = newton.solve(system, x, step, sections, attempt.damping, interrupt)
    moved = longest_move(solution.x - state.x)
    if pacing.too_far(moved, trial):
        raise StepFailed(f"a node moved by {moved:.3g} mm in one step")
    return solution, system.commit(solution.x, step)


def _outcome(
    system: System, solution: Solution, state: State, rejected: int, sections: Sections, pacing: Pacing
) -> Outcome:
    moved = longest_move(solution.x - state.x)
    if not pacing.watches_balance:
        return Outcome(solution.iterations, moved, rejected)
    carried = sections.largest_sum(system.rate_forces(solution.x))
    load = system.largest_load(solution.x, solution.residual)
    return Outcome(solution.iterations, moved, rejected, carried, load, system.slip())
