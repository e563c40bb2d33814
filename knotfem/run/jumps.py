"""Jumps: what the rods do where a branch of equilibria ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.energy.balance import StepFigures
from knotfem.energy.energies import Energies
from knotfem.models.base import Model
from knotfem.solver.stepping.integrator import AcceptedStep

JUMP_OVER_DIAMETER = 0.1
"""Rods that move by less under loads that stand still only catch up."""


@dataclass(frozen=True)
class Jump:
    """A motion under loads that stand still.

    Attributes:
        step: of the scene.
        time: [s].
        displacement: of the reported end over all steps after tying [mm].
        step_displacement: the same since the start of the scene's step [mm].
        force_before, force_after: on that end [N]; before is nan where no equilibrium of the step precedes.
        rod: name of the rod that moved furthest.
        arclength_fraction: where on it, s/L.
        moved: how far that place moved [mm].
        released: energy that viscous terms took [N mm].
        steps: that it took.
    """

    step: str
    time: float
    displacement: float
    step_displacement: float
    force_before: float
    force_after: float
    rod: str
    arclength_fraction: float
    moved: float
    released: float
    steps: int

    def __str__(self) -> str:
        before = "" if math.isnan(self.force_before) else f"{self.force_before:.4g} to "
        return (
            f"jump at {self.displacement:.4g} mm, {self.rod} moves by {self.moved:.3g} mm at s/L = "
            f"{self.arclength_fraction:.2f}, force {before}{self.force_after:.4g} N, "
            f"{self.released:.3g} N mm released"
        )


@dataclass(frozen=True, eq=False)
class Mark:
    """An accepted state to which others are held.

    Attributes:
        x: unknowns, shape [nodes, width].
        force: on the reported end [N]; nan before the first step.
        taken: energy that viscous terms had taken [N mm].
    """

    x: np.ndarray
    force: float
    taken: float


class JumpWatch:
    """Watches the rods while loads stand still.

    Args:
        model: of the scene.
        x: unknowns with which a step of the scene begins, shape [nodes, width].
        taken: energy that viscous terms have taken [N mm].
    """

    def __init__(self, model: Model, x: np.ndarray, taken: float = 0.0) -> None:
        self.model = model
        self._settled = Mark(x, float("nan"), taken)
        self._steps = 0
        self._named = x

    def update(
        self, step: str, accepted: AcceptedStep, figures: StepFigures, energies: Energies, displaced: float = 0.0
    ) -> Jump | None:
        """A step was accepted.

        Args:
            step: name of the scene's step.
            accepted: the time step.
            figures: of it.
            energies: so far.
            displaced: displacement with which the scene's step set out [mm].

        Returns:
            The jump that ended with it; None where the rods only caught up with their loads, or still move.
        """
        before, moving = self._settled, self._steps > 0
        if not accepted.settled:
            self._steps += 1
            return None
        steps, self._steps = self._steps + 1, 0
        self._named = accepted.state.x
        self._settled = Mark(accepted.state.x, figures.force, sum(energies.taken.values()))
        if not moving:
            return None
        rod, fraction, moved = furthest(self.model, before.x, accepted.state.x)
        if moved < JUMP_OVER_DIAMETER * self.model.diameter:
            return None
        return Jump(
            step,
            accepted.state.time,
            displaced + figures.displacement,
            figures.displacement,
            before.force,
            figures.force,
            self.model.rods[rod].name,
            fraction,
            moved,
            self._settled.taken - before.taken,
            steps,
        )

    def wandered(self, x: np.ndarray) -> bool:
        """Whether rods in motion have gone by a diameter since this was last so; their knots are named anew then."""
        if self._steps == 0 or furthest(self.model, self._named, x)[2] < self.model.diameter:
            return False
        self._named = x
        return True

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        return {"settled": dict(vars(self._settled)), "steps": self._steps, "named": self._named}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self._settled, self._steps, self._named = Mark(**state["settled"]), int(state["steps"]), state["named"]


def furthest(model: Model, before: np.ndarray, after: np.ndarray) -> tuple[int, float, float]:
    """Rod, s/L and move [mm] of the centreline's place that moved furthest between two states."""
    found = (0, 0.0, -1.0)
    for rod, (start, end) in enumerate(zip(model.centrelines(before), model.centrelines(after), strict=True)):
        moves = np.linalg.norm(end - start, axis=1)
        place = int(np.argmax(moves))
        if moves[place] > found[2]:
            found = (rod, place / (len(moves) - 1), float(moves[place]))
    return found
