"""What decides how long steps are, and what it needs to know of the last one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np


@dataclass(frozen=True)
class Pace:
    """How the next step is meant to be.

    Attributes:
        advance: by how much loads advance in it [s]; before output times shorten it.
        settling: whether loads stand still instead, until the rods are in equilibrium.
        dt: time over which rates are taken in a step in which loads stand still [s].
        slowness: factor on the time over which rates are taken while loads advance; 1 far from any jump.
        due: whether an output time is reached whose state is not in equilibrium yet.
    """

    advance: float
    settling: bool = False
    dt: float = 0.0
    slowness: float = 1.0
    due: bool = False


class StepTimes(NamedTuple):
    """Times by which loads and rates go on in a step.

    Attributes:
        advance: of loads [s].
        dt: over which rates are taken [s].
    """

    advance: float
    dt: float

    @property
    def loads_advance(self) -> bool:
        """Whether loads advance, or stand still."""
        return self.advance > 0.0

    @property
    def span(self) -> float:
        """Time by which the step goes [s]: that of loads, or of rates where they stand still."""
        return self.advance if self.loads_advance else self.dt


@dataclass(frozen=True)
class Trial:
    """A step that is tried.

    Attributes:
        advance: by how much loads advance [s].
        at_output: whether loads then are at an output time.
        rates_over: time over which rates are taken [s]; None for real time, in which it is `advance`.
    """

    advance: float
    at_output: bool
    rates_over: float | None = None

    @property
    def dt(self) -> float:
        """Time over which rates are taken [s]."""
        return self.advance if self.rates_over is None else self.rates_over

    @property
    def times(self) -> StepTimes:
        """By which it goes on."""
        return StepTimes(self.advance, self.dt)


@dataclass(frozen=True)
class Outcome:
    """How a step went that was accepted.

    Attributes:
        iterations: of Newton's method.
        moved: longest move of a node [mm].
        rejected: attempts that were rejected before.
        carried: largest force of viscous terms and inertia, summed up to any cross-section [N]; nan where the pacing
            does not ask for it.
        load: largest force on an end of a rod [N]; likewise.
        slip: longest slip of a contact [mm]; likewise.
    """

    iterations: int
    moved: float
    rejected: int
    carried: float = float("nan")
    load: float = float("nan")
    slip: float = 0.0


class Pacing(Protocol):
    """Decides on steps; it has no state."""

    @property
    def watches_balance(self) -> bool:
        """Whether it asks what viscous terms and inertia carry."""
        ...

    def start(self) -> Pace:
        """For the first step."""
        ...

    def trial(self, pace: Pace, now: float, output_times: np.ndarray) -> Trial | None:
        """The next step to try; None where there is nothing left to do.

        Args:
            pace: as it is meant to be.
            now: accepted time [s].
            output_times: ascending [s]; they are met exactly.
        """
        ...

    def too_far(self, moved: float, trial: Trial) -> bool:
        """Whether a step that moved a node by so much [mm] is rejected."""
        ...

    def after_failure(self, pace: Pace, trial: Trial) -> Pace | None:
        """The next attempt; None where there is none left."""
        ...

    def after_success(self, pace: Pace, trial: Trial, outcome: Outcome) -> Pace:
        """The next step, after one that was accepted.

        Args:
            pace: of the attempt that succeeded.
            trial: what was done.
            outcome: how it went.
        """
        ...
