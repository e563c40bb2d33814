"""What a simulation yields as it goes on."""

from __future__ import annotations

from dataclasses import dataclass

from knotfem.energy.balance import StepFigures
from knotfem.energy.energies import Energies
from knotfem.models.base import Increment
from knotfem.run.jumps import Jump
from knotfem.scene.steps import Step
from knotfem.solver.state import State
from knotfem.solver.stepping.integrator import AcceptedStep
from knotfem.solver.system import System


@dataclass(frozen=True, eq=False)
class TimeStepDone:
    """An accepted time step.

    Attributes:
        step: of the scene.
        accepted: the time step.
        figures: of the step.
        energies: so far.
        system: equations, with the terms in the accepted state.
        elapsed: since the scene's step began [s].
        fraction: of the scene's step that is done, 0 to 1; nan where nobody knows.
        output: whether outputs are due.
        last: whether it is the last of the scene's step.
        equilibrium: whether viscous terms and inertia carry no more than the scene's `quasi_static.tolerance` allows.
        jump: that ended with it, or None.
        before: displacement with which the scene's step set out [mm].
        drawn_in: length of the free end that has been drawn in furthest since the scene's step began [mm]; 0 where no
            step shows whether the knot holds.
    """

    step: Step
    accepted: AcceptedStep
    figures: StepFigures
    energies: Energies
    system: System
    elapsed: float
    fraction: float
    output: bool
    last: bool
    equilibrium: bool
    jump: Jump | None
    before: float
    drawn_in: float

    @property
    def state(self) -> State:
        """The accepted state."""
        return self.accepted.state

    @property
    def time(self) -> float:
        """Time [s]."""
        return self.state.time

    @property
    def force(self) -> float:
        """Along the reported drive, at its end [N]."""
        return self.figures.force

    @property
    def displacement(self) -> float:
        """Of that end over all steps after tying [mm]; what a step goes back is not taken off for the next ones."""
        return self.before + self.figures.displacement

    @property
    def step_displacement(self) -> float:
        """Of that end since the start of the scene's step [mm]."""
        return self.figures.displacement


@dataclass(frozen=True)
class PhaseDone:
    """The mapping, or a step of the scene, is through.

    Attributes:
        name: of the phase.
        tied: whether the knot is tied with it.
    """

    name: str
    tied: bool


Event = Increment | TimeStepDone | PhaseDone
