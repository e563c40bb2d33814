"""How long time steps are: a pure function of how the last ones went."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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

    def too_far(self, moved: float, dt: float) -> bool:
        """Whether a step that moved a node by so much is to be rejected."""
        return moved > self.most_move * self.move and dt > self.smallest

    def after_failure(self, dt: float) -> float | None:
        """Length of the next attempt, or None where there is none left."""
        return None if dt <= self.smallest else self.cut * dt

    def after_success(self, dt: float, wanted: float, iterations: int, moved: float, rejected: int) -> float:
        """Length that the next step is wanted to have.

        Args:
            dt: of the accepted step.
            wanted: what it was wanted to be, before output times shortened it.
            iterations: that it took.
            moved: longest move of a node in it [mm].
            rejected: attempts that were rejected before.
        """
        if not rejected and iterations <= self.few:
            factor = self.grow
        elif not rejected and iterations >= self.many:
            factor = self.shrink
        else:
            factor = 1.0
        base = dt if rejected or dt > 0.5 * wanted else wanted
        if moved > 0.0:
            factor = min(factor, self.move / moved * dt / base)
        return min(max(factor * base, self.smallest), self.largest)
