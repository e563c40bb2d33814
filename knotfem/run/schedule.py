"""Step control and output times of a scene's steps, and when one is at rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.energy.balance import StepFigures
from knotfem.energy.energies import Energies
from knotfem.models.base import Model
from knotfem.scene.steps import Pull, Relax, Release, Step
from knotfem.solver.stepping.controller import StepController

FIRST_MOVE_OVER_DIAMETER = 1.0 / 60.0
"""How far a driven end goes in the first step."""
REST_FORCE = 2e-5
"""At rest drag and inertia carry less than this fraction of B/r^2 along the rod."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """How a scene's step is integrated.

    Attributes:
        controller: of time steps.
        output_times: when outputs are due [s], ascending; the last ends the step.
    """

    controller: StepController
    output_times: np.ndarray

    def fraction(self, began: float, now: float) -> float:
        """How much of it is done, 0 to 1."""
        length = float(self.output_times[-1]) - began
        return (now - began) / length if length > 0.0 else 1.0

    def over(self, now: float) -> bool:
        """Whether its time is over."""
        return now >= self.output_times[-1] * (1.0 - 1e-12)


def schedule_of(model: Model, step: Step, began: float) -> Schedule:
    """The schedule of a scene's step that begins at `began` [s]."""
    scene, d = model.scene, model.diameter
    move = scene.solver.move_over_diameter * d
    if isinstance(step, Pull):
        length, every = step.duration, scene.output.every_displacement / step.speed
        first = min(FIRST_MOVE_OVER_DIAMETER * d, move) / step.speed
    elif isinstance(step, Relax):
        length, every, first = step.longest, step.longest, 1e-4 * step.longest
    else:
        length, every = step.duration, scene.output.every_time
        first = 1e-3 * length
    count = max(1, int(np.ceil(length / every - 1e-9)))
    times = began + np.minimum(np.arange(1, count + 1) * every, length)
    smallest = first * 0.4**scene.solver.max_cutbacks
    return Schedule(StepController(first=first, smallest=smallest, largest=length, move=move), times)


class Rest:
    """Says when a relaxing or released rod has come to rest.

    Its friction schedule must have run out; the kinetic energy must be below the step's fraction of the elastic energy,
    and static balance lack at most `REST_FORCE` B/r^2 (2e-4 N for the paper's rod): the largest sum of drag and inertia
    from one end of a rod up to any of its sections.

    Args:
        step: of the scene.
        model: of the scene.
        began: when the step began [s].
    """

    def __init__(self, step: Relax | Release, model: Model, began: float) -> None:
        schedule = step.friction_schedule
        self.earliest = began + (schedule[-1].time if schedule else 0.0)
        self.kinetic_over_elastic = step.kinetic_over_elastic
        self.force = REST_FORCE * model.force_scale

    def reached(self, time: float, energies: Energies, figures: StepFigures) -> bool:
        """Whether an accepted step ended at rest at a time [s]."""
        if time < self.earliest * (1.0 - 1e-12):
            return False
        slow = energies.kinetic <= self.kinetic_over_elastic * max(energies.elastic, 1e-300)
        return figures.dynamic_residual < self.force and slow
