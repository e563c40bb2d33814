"""Step control and output times of a scene's steps, and when one is at rest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from knotfem.energy.balance import StepFigures
from knotfem.energy.energies import Energies
from knotfem.models.base import Model
from knotfem.scene.steps import Pull, Relax, Release, Step
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep
from knotfem.solver.stepping.pace import Pacing
from knotfem.solver.stepping.quasi_static import QuasiStatic

FIRST_MOVE_OVER_DIAMETER = 1.0 / 60.0
"""How far a driven end goes in the first step."""
NOMINAL_TIME = 1.0
"""That passes in a quasi-static relax step [s], so that no two states have the same time."""
REST_FORCE = 2e-5
"""At rest drag and inertia carry less than this fraction of B/r^2 along the rod."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """How a scene's step is integrated.

    Attributes:
        pacing: of steps.
        output_times: when outputs are due [s], ascending; the last ends the step.
        tolerance: largest fraction of the load that viscous terms and inertia carry in an equilibrium.
        floor: the balance itself is known no better than this [N].
        still: whether nothing changes with time: the step takes as long as rods take to settle.
    """

    pacing: Pacing
    output_times: np.ndarray
    tolerance: float
    floor: float
    still: bool = False

    def in_equilibrium(self, accepted: AcceptedStep, figures: StepFigures) -> bool:
        """Whether an accepted step ended in equilibrium, in real time by what is carried in comparison to the force."""
        if self.pacing.watches_balance:
            return accepted.settled
        return figures.dynamic_residual <= max(self.tolerance * abs(figures.force), self.floor)

    def fraction(self, began: float, now: float) -> float:
        """How much of it is done, 0 to 1; nan where it takes as long as rods take to settle."""
        return float("nan") if self.still else (now - began) / (float(self.output_times[-1]) - began)

    def over(self, now: float) -> bool:
        """Whether its time is over."""
        return now >= self.output_times[-1] * (1.0 - 1e-12)


def schedule_of(model: Model, step: Step, began: float) -> Schedule:
    """The schedule of a scene's step that begins at `began` [s]."""
    scene, d = model.scene, model.diameter
    move = scene.solver.move_over_diameter * d
    length = duration_of(step)
    still = not step.real and isinstance(step, Relax | Release) and not step.friction_schedule
    if isinstance(step, Pull):
        every = scene.output.every_displacement / step.nominal_speed
        first = min(FIRST_MOVE_OVER_DIAMETER * d, move) / step.nominal_speed
    elif isinstance(step, Relax) or still:
        every, first = length, 1e-4 * length
    else:
        every, first = scene.output.every_time, 1e-3 * length
    count = max(1, int(np.ceil(length / every - 1e-9)))
    times = began + np.minimum(np.arange(1, count + 1) * every, length)
    smallest = first * 0.4**scene.solver.max_cutbacks
    real = StepController(first=first, smallest=smallest, largest=length, move=move)
    tolerance, floor = scene.quasi_static.tolerance, ForceTolerance.of(scene.solver.force_tolerance).resultant
    pacing = real if step.real else replace(_quasi_static(model, real, floor), still=still)
    return Schedule(pacing, times, tolerance, floor, still)


def duration_of(step: Step) -> float:
    """How long the loads of a step change, or in real time how long it lasts at most [s]."""
    if not step.real and isinstance(step, Relax):
        return step.friction_schedule[-1].time if step.friction_schedule else NOMINAL_TIME
    return step.longest if isinstance(step, Relax) else step.duration


def _quasi_static(model: Model, loads: StepController, floor: float) -> QuasiStatic:
    solver, rule, d = model.scene.solver, model.scene.quasi_static, model.diameter
    move, slip = rule.settling_move_over_diameter * d, rule.settling_slip_over_diameter * d
    pacing = QuasiStatic(loads, model.mass, model.force_scale, rule.tolerance, floor, move, slip)
    return replace(pacing, shortest=pacing.hurry**solver.max_cutbacks)


class Rest:
    """Says when a relaxing or released rod has come to rest in real time.

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
