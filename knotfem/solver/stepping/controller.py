"""Steps in real time: their length follows how the last ones went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.solver.stepping.pace import Outcome, Pace, Trial


@dataclass(frozen=True)
class StepController:
    """Length of time steps by the iterations they took and by how far they moved a node; lengths in mm, times in s.

    Attributes:
        first: length of the first step.
        smallest: a step that fails below it ends the run.
        largest: longest step.
        move: largest move of a node in a step that is aimed at.
        few, grow: up to so many iterations the next step is longer by this factor.
        many, shrink: from so many iterations on it is shorter by this factor.
        cut: factor after a failure.
        most_move: a step that moves a node further than so many times `move` is rejected and retried shorter: the work
            of forces on so long a path is all but unknown (2 % of the energy went missing where an end was let go), and
            a strand that whips across a thin one would come out on its far side.
    """

    first: float
    smallest: float
    largest: float
    move: float
    few: int = 5
    many: int = 10
    grow: float = 1.4
    shrink: float = 0.7
    cut: float = 0.4
    most_move: float = 1.5

    @property
    def watches_balance(self) -> bool:
        """Real time goes on whatever viscous terms and inertia carry."""
        return False

    def start(self) -> Pace:
        """For the first step."""
        return Pace(self.first)

    def trial(self, pace: Pace, now: float, output_times: np.ndarray) -> Trial | None:
        """The next step to try."""
        if reached(now, output_times):
            return None
        dt, at_output = self.length(pace.advance, now, output_times)
        return Trial(dt, at_output)

    def length(self, dt: float, now: float, output_times: np.ndarray) -> tuple[float, bool]:
        """Length of the next step, such that output times are met exactly, and whether it ends at one.

        Args:
            dt: that is wanted.
            now: time [s].
            output_times: ascending [s].
        """
        ahead = output_times[output_times > now + 1e-12 * max(1.0, abs(now))]
        left = float(ahead[0]) - now
        if dt >= left * (1.0 - 1e-9):
            return left, True
        return (0.5 * left, False) if dt > 0.6 * left else (dt, False)

    def too_far(self, moved: float, trial: Trial) -> bool:
        """Whether a step that moved a node by so much is to be rejected."""
        return moved > self.most_move * self.move and trial.advance > self.smallest

    def after_failure(self, pace: Pace, trial: Trial) -> Pace | None:
        """A shorter attempt, or None where there is none left."""
        return None if trial.advance <= self.smallest else Pace(self.cut * trial.advance)

    def after_success(self, pace: Pace, trial: Trial, outcome: Outcome) -> Pace:
        """The next step."""
        return Pace(self.next_length(pace.advance, trial.advance, outcome))

    def next_length(self, wanted: float, dt: float, outcome: Outcome, grow: float | None = None) -> float:
        """Length that the next step is wanted to have.

        Args:
            wanted: what the last one was wanted to be, before output times shortened it.
            dt: what it was.
            outcome: how it went.
            grow: factor after an easy step; None for `grow`.
        """
        if not outcome.rejected and outcome.iterations <= self.few:
            factor = self.grow if grow is None else grow
        elif not outcome.rejected and outcome.iterations >= self.many:
            factor = self.shrink
        else:
            factor = 1.0
        base = dt if outcome.rejected or dt > 0.5 * wanted else wanted
        if outcome.moved > 0.0:
            factor = min(factor, self.move / outcome.moved * dt / base)
        return min(max(factor * base, self.smallest), self.largest)


def reached(now: float, output_times: np.ndarray) -> bool:
    """Whether the last output time is reached [s]."""
    end = float(output_times[-1])
    return now >= end - 1e-12 * max(1.0, abs(end))
