"""Step control of a scene's steps, and when one is at rest."""

from __future__ import annotations

import os
from dataclasses import asdict
from typing import Any

import numpy as np

from knotfem.run.account import Balance, Energies
from knotfem.run.build import Body
from knotfem.scene.model import Scene
from knotfem.scene.steps import Pull, Relax, Release, Step
from knotfem.solver import march
from knotfem.solver.effect import Motion
from knotfem.solver.newton import NewtonSettings
from knotfem.solver.system import System

MOVE_OVER_DIAMETER = 0.5
"""Largest move of a node in a step that is aimed at."""
FIRST_MOVE_OVER_DIAMETER = 1.0 / 60.0
"""How far a driven end goes in the first step."""
REST_MOVE_OVER_DIAMETER = 1e-3
"""At rest no node moves further in the last step, which must be as long as all before it together."""


def threads_of(scene: Scene) -> int:
    """Threads that the scene asks for, or all there are."""
    return scene.solver.threads or len(os.sched_getaffinity(0))


def newton_settings(scene: Scene, body: Body) -> NewtonSettings:
    """Newton's settings in units of the rod."""
    d = min(rod.scene.diameter for rod in body.rods)
    tolerance = scene.solver.force_tolerance
    return NewtonSettings(
        force_tolerance=tolerance,
        resultant_tolerance=10.0 * tolerance,
        max_iterations=scene.solver.max_iterations,
        largest_move=0.25 * d,
        endgame_move=0.005 * d,
    )


def march_of(
    scene: Scene, step: Step, system: System, progress: march.Progress, body: Body, began: float
) -> march.March:
    """The march of a scene's step; it ends at the last of its stops, where outputs are due."""
    d = min(rod.scene.diameter for rod in body.rods)
    if isinstance(step, Pull):
        length, every = step.duration, scene.output.every_displacement / step.speed
        first = FIRST_MOVE_OVER_DIAMETER * d / step.speed
    elif isinstance(step, Relax):
        length, every, first = step.longest, step.longest, 1e-4 * step.longest
    else:
        length, every = step.duration, scene.output.every_time
        first = 1e-3 * length
    count = max(1, int(np.ceil(length / every - 1e-9)))
    stops = began + np.minimum(np.arange(1, count + 1) * every, length)
    smallest = first * 0.4**scene.solver.max_cutbacks
    control = march.StepControl(first=first, smallest=smallest, largest=length, move=MOVE_OVER_DIAMETER * d)
    return march.March(system, progress, control, newton_settings(scene, body), body.sections, stops)


class AtRest:
    """Says when a relaxing or released rod has come to rest.

    The kinetic energy (of the mean velocity over the step, whatever the scheme) is below the step's share of the
    elastic energy, and no node has moved by more than a thousandth of a diameter in a step that was no shorter than
    a tenth of all the time since the start: then the out-of-balance static forces are those of drag and inertia at
    that velocity, and vanish with it.
    """

    def __init__(self, step: Relax | Release, scene: Scene) -> None:
        self.share = step.kinetic_over_elastic
        self.move = REST_MOVE_OVER_DIAMETER * min(rod.diameter for rod in scene.rods)

    def reached(self, accepted: march.Accepted, energies: Energies, balance: Balance) -> bool:
        """Whether an accepted step ended at rest."""
        moved = float(np.abs(accepted.motion.x - accepted.start.motion.x).max())
        return moved < self.move and energies.kinetic <= self.share * max(energies.elastic, 1e-300)


def stored_progress(progress: march.Progress) -> dict[str, Any]:
    """For a checkpoint."""
    state = {key: value for key, value in vars(progress).items() if key != "motion"}
    return {**state, "motion": asdict(progress.motion)}


def restored_progress(state: dict[str, Any]) -> march.Progress:
    """From a checkpoint."""
    values = dict(state["progress"])
    return march.Progress(Motion(**values.pop("motion")), **values)
