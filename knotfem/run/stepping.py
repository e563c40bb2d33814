"""Step control of a scene's steps, and when one is at rest."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from knotfem.energy.account import Balance, Energies
from knotfem.errors import InputError
from knotfem.models.base import Simulation
from knotfem.run.machine import default_threads
from knotfem.scene.model import Scene
from knotfem.scene.steps import Load, Pull, Relax, Release, Step
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.stepping import integrator as march
from knotfem.solver.system import System
from knotfem.solver.term import Motion

FIRST_MOVE_OVER_DIAMETER = 1.0 / 60.0
"""How far a driven end goes in the first step."""
REST_FORCE = 2e-5
"""At rest drag and inertia carry less than this share of B/r^2 along the rod."""


def threads_of(scene: Scene) -> int:
    """Threads that the scene asks for, or as many as this process may take."""
    return scene.solver.threads or default_threads()


def newton_settings(model: Simulation) -> NewtonSettings:
    """Newton's settings in units of the rod."""
    scene, d = model.scene, model.diameter
    tolerance = scene.solver.force_tolerance
    return NewtonSettings(
        force_tolerance=tolerance,
        resultant_tolerance=10.0 * tolerance,
        max_iterations=scene.solver.max_iterations,
        largest_move=0.25 * d,
        endgame_move=0.025 * d,
    )


def march_of(model: Simulation, step: Step, system: System, progress: march.Progress, began: float) -> march.March:
    """The march of a scene's step; it ends at the last of its stops, where outputs are due."""
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
    stops = began + np.minimum(np.arange(1, count + 1) * every, length)
    smallest = first * 0.4**scene.solver.max_cutbacks
    control = march.StepControl(first=first, smallest=smallest, largest=length, move=move)
    return march.March(system, progress, control, newton_settings(model), model.sections, stops)


class AtRest:
    """Says when a relaxing or released rod has come to rest.

    Its friction schedule must have run out; the kinetic energy must be below the step's share of the elastic energy,
    and static balance lack at most `REST_FORCE` B/r^2 (2e-4 N for the paper's rod): the largest sum of drag and inertia
    from one end of a rod up to any of its sections.
    """

    def __init__(self, step: Relax | Release, model: Simulation, began: float) -> None:
        schedule = step.friction_schedule
        self.earliest = began + (schedule[-1].time if schedule else 0.0)
        self.share = step.kinetic_over_elastic
        self.force = REST_FORCE * model.force_scale

    def reached(self, time: float, energies: Energies, balance: Balance) -> bool:
        """Whether an accepted step ended at rest at a time [s]."""
        if time < self.earliest * (1.0 - 1e-12):
            return False
        return balance.unrest < self.force and energies.kinetic <= self.share * max(energies.elastic, 1e-300)


@dataclass(frozen=True, eq=False)
class Underway:
    """A step that has begun, as a checkpoint within it keeps it.

    Attributes:
        step: of the scene.
        began: when [s].
        origin: state at that time, shape [nodes, unknowns].
        before: force on each loaded end at that time [N], by label, shape [3].
        progress: how far the march has come.
    """

    step: Step
    began: float
    origin: np.ndarray
    before: dict[str, np.ndarray]
    progress: march.Progress

    @classmethod
    def restored(cls, step: Step, state: dict[str, Any]) -> Underway:
        """From a checkpoint within the step.

        Raises:
            InputError: it lacks the forces that a load sets out from.
        """
        before = state.get("before", {})
        if isinstance(step, Load) and ("before" not in state or any(np.ndim(force) == 0 for force in before.values())):
            raise InputError(
                "the checkpoint is of an older version, without the forces at the start of the load",
                key=f"steps.{step.name}",
                expected="a new run",
            )
        return cls(step, float(state["began"]), state["origin"], before, restored_progress(state))

    def stored(self) -> dict[str, Any]:
        """For a checkpoint."""
        start = {"began": self.began, "origin": self.origin, "before": self.before}
        return {"progress": stored_progress(self.progress), **start}


def stored_progress(progress: march.Progress) -> dict[str, Any]:
    """For a checkpoint."""
    state = {key: value for key, value in vars(progress).items() if key != "motion"}
    return {**state, "motion": asdict(progress.motion)}


def restored_progress(state: dict[str, Any]) -> march.Progress:
    """From a checkpoint."""
    values = dict(state["progress"])
    return march.Progress(Motion(**values.pop("motion")), **values)
