"""The same knot moved, mirrored, numbered the other way and with its facets elsewhere pulls with the same force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from knotfem.mesh.section import Section
from knotfem.models.solid.body import meshes_of
from knotfem.models.solid.model import SolidModel
from knotfem.run.events import PhaseDone
from knotfem.run.simulation import Simulation
from knotfem.scene.model import Scene
from knotfem.scene.steps import Driven
from knotfem.solver.state import Motion, State
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.outcome import Outcome
from knotfem.verify.stress.runs import Recording, hard_case, hard_scene

NAME = "invariance"
Q = np.array([[0.36, 0.48, -0.80], [-0.80, 0.60, 0.0], [0.48, 0.64, 0.60]])
"""A rotation."""
SHIFT = np.array([31.0, -17.0, 53.0])
MIRROR = np.diag([1.0, 1.0, -1.0])
Scenes = Callable[..., Scene]
"""Makes the scene, with overrides."""


@dataclass(frozen=True, eq=False)
class Pulled:
    """A knot that was pulled.

    Attributes:
        outcome: of its run.
        displacement: at the outputs of the pull [mm], shape [outputs].
        force: there [N], shape [outputs].
    """

    outcome: Outcome
    displacement: np.ndarray
    force: np.ndarray


Changed = Callable[[Scenes, np.ndarray], Pulled]
"""Pulls the changed knot, from its scene and the tied positions of the unchanged one [mm], shape [nodes, 3]."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
    scene = _scene(small)
    tight, loose = 1e-6, 0.05 if small else 0.01

    def case(variant: str, title: str, changed: Changed, limit: float) -> Case:
        return hard_case(NAME, variant, title, partial(_compare, changed, limit, small), scene, small=small)

    return [
        case("moved", "overhand turned and moved as a whole", _moved, tight),
        case("mirrored", "mirror image of the overhand", _mirrored, tight),
        case("renumbered", "section numbered the other way", _renumbered, tight),
        case("facets", "section turned by half a facet", _turned, loose),
    ]


def _scene(small: bool, *overrides: str) -> Scene:
    pull = ("steps.1.displacement=3 mm", "output.every_displacement=1 mm") if small else ()
    return hard_scene(NAME, (*pull, *overrides), small=small)


@cache
def _unchanged(small: bool) -> tuple[np.ndarray, Pulled]:
    """The knot with which all others are compared: tied positions [mm], shape [nodes, 3], and its pull."""
    x = _tied(_scene(small))
    return x, _pulled(_scene(small), x)


def _compare(changed: Changed, limit: float, small: bool) -> Sequence[Quantity]:
    x, first = _unchanged(small)
    other = changed(partial(_scene, small), x)
    scale = float(np.abs(first.force).max())
    difference = float(np.abs(other.force - first.force).max()) / scale
    apart = float(np.abs(other.displacement - first.displacement).max())
    return [
        *other.outcome.quantities(before="3_1", after="3_1"),
        Quantity("same displacements, mm", apart, 1e-9, kind="at most"),
        Quantity("largest difference of the force over the force", difference, limit, kind="at most"),
        Quantity("largest force, N", scale, 0.01, kind="at least"),
    ]


def _tied(scene: Scene, section: Section | None = None) -> np.ndarray:
    """Positions after the mapping [mm], shape [nodes, 3].

    Args:
        scene: what to tie.
        section: of the rod, instead of the scene's.
    """
    simulation = Simulation(scene, "tie", model=SolidModel(scene, section=section))
    next(event for event in simulation.run() if isinstance(event, PhaseDone))
    return simulation.state.x


def _pulled(scene: Scene, x: np.ndarray, section: Section | None = None) -> Pulled:
    """All steps of a scene from rest at given positions; pressures and core forces begin at zero.

    Args:
        scene: what to run.
        x: tied positions [mm], shape [nodes, 3].
        section: of the rod, instead of the scene's.
    """
    simulation = Simulation(scene, model=SolidModel(scene, section=section))
    simulation.start_at(State.of(Motion.at_rest(x), {}))
    recording = Recording(simulation)
    outputs = [
        (step.displacement, step.force)
        for step in recording
        if step.step is scene.steps[-1] and step.accepted.at_output
    ]
    displacement, force = np.array(outputs).T
    return Pulled(recording.outcome(), displacement, force)


def _section(scene: Scene) -> Section:
    return meshes_of(scene)[0][0].section


def _direction(vector: np.ndarray) -> str:
    return f"steps.1.ends.rod.start.direction={vector.tolist()}"


def _pulled_along(scene: Scene) -> np.ndarray:
    end = scene.steps[1].ends["rod"].start
    assert isinstance(end, Driven)
    return np.array(end.direction)


def _moved(scene: Scenes, x: np.ndarray) -> Pulled:
    return _pulled(scene(_direction(Q @ _pulled_along(scene()))), x @ Q.T + SHIFT)


def _mirrored(scene: Scenes, x: np.ndarray) -> Pulled:
    points = _section(scene()).points
    twin = twins(points, points * [1.0, -1.0])
    sections = x.reshape(-1, len(points), 3)
    return _pulled(scene(_direction(MIRROR @ _pulled_along(scene()))), (sections[:, twin] @ MIRROR).reshape(-1, 3))


def _renumbered(scene: Scenes, x: np.ndarray) -> Pulled:
    section = _section(scene())
    last = len(section.points) - 1
    reverse = Section(section.points[::-1].copy(), last - section.quads[::-1], last - section.axis, last - section.ring)
    return _pulled(scene(), x.reshape(-1, last + 1, 3)[:, ::-1].reshape(-1, 3), reverse)


def _turned(scene: Scenes, x: np.ndarray) -> Pulled:
    section = _section(scene())
    angle = np.pi / section.sides
    c, s = np.cos(angle), np.sin(angle)
    points = section.points @ np.array([[c, s], [-s, c]])
    turned = Section(points, section.quads, section.axis, section.ring)
    return _pulled(scene(), _tied(scene(), turned), turned)


def twins(points: np.ndarray, images: np.ndarray) -> np.ndarray:
    """For each image the point that lies there, shape [n].

    Args:
        points: shape [n, 2].
        images: shape [n, 2].
    """
    distance = np.linalg.norm(points[None] - images[:, None], axis=2)
    assert distance.min(axis=1).max() < 1e-6, "the section is not its own mirror image"
    return distance.argmin(axis=1)
