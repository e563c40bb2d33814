"""What an integration in time needs to go on, and the move that it expects next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.solver.state import State
from knotfem.solver.stepping.pace import Pace, StepTimes, Trial

ROUGH = 0.25
"""Change of velocity from one step to the next, over the velocity, of which a half is extrapolated: of less nearly all,
of more, where the motion is not smooth, next to nothing. With it the bowline takes a quarter fewer iterations, the
figure-eight knot 40 %."""


@dataclass(frozen=True, eq=False)
class Continuation:
    """All that the integration needs to go on.

    Attributes:
        state: accepted.
        increment: last accepted move [mm], shape [nodes, width].
        advance: of loads in the step of that move [s].
        dt: time over which rates were taken in it [s]; 0 where there is no move to extrapolate.
        earlier: move of the step before [mm], shape [nodes, width], where it was of the same kind: loads advanced in
            both, or stood still in both.
        earlier_span: time of that step [s]; 0 where it was of the other kind.
        pace: how the next step is meant to be, None for the first.
        damping: Levenberg-Marquardt damping to begin with [N/mm].
    """

    state: State
    increment: np.ndarray
    advance: float = 0.0
    dt: float = 0.0
    earlier: np.ndarray | None = None
    earlier_span: float = 0.0
    pace: Pace | None = None
    damping: float = 0.0

    @classmethod
    def at(cls, state: State) -> Continuation:
        """At the beginning."""
        return cls(state, np.zeros_like(state.x))

    @property
    def times(self) -> StepTimes:
        """Of the last move."""
        return StepTimes(self.advance, self.dt)

    def predicted(self, trial: Trial) -> np.ndarray | None:
        """Move of a step to be tried [mm], shape [nodes, width], or None where nothing is known of it.

        Loads that advance carry the rods along, drag where they stand. The velocity changes as it did last, as long as
        that was little; from the one kind of motion to the other nothing is known of the move to come.
        """
        if not self._alike(trial):
            return None
        before, span = self.times.span, trial.times.span
        velocity = self.increment / before
        if self.earlier is not None and self.earlier_span > 0.0:
            change = velocity - self.earlier / self.earlier_span
            change *= (before + span) / (self.earlier_span + before)
            steady, rough = (ROUGH * np.linalg.norm(velocity)) ** 4, np.linalg.norm(change) ** 4
            velocity = velocity + change * (steady / (steady + rough) if steady > 0.0 else 0.0)
        return span * velocity

    def followed_by(self, state: State, trial: Trial, pace: Pace, damping: float) -> Continuation:
        """After a step that was accepted.

        Args:
            state: that it ended at.
            trial: the step.
            pace: of the next one.
            damping: to begin the next one with [N/mm].
        """
        increment = state.x - self.state.x
        earlier, span = (self.increment, self.times.span) if self._alike(trial) else (None, 0.0)
        return Continuation(state, increment, trial.advance, trial.dt, earlier, span, pace, damping)

    def _alike(self, trial: Trial) -> bool:
        """Whether there is a last move, of the kind of a step to be tried."""
        return self.dt > 0.0 and self.times.loads_advance == trial.times.loads_advance
