"""The same knot moved, mirrored, numbered the other way and with its facets elsewhere pulls with the same force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

import numpy as np

from knotfem.mesh.section import Section
from knotfem.scene.model import Scene
from knotfem.scene.steps import Driven
from knotfem.verify.rehearsal import Passed, Rehearsal, force_curve
from knotfem.verify.stress.cases import hard_case, hard_scene
from knotfem.verify.stress.figures import figures_of
from knotfem.verify.verdict import Case, Quantity

NAME = "invariance"
Q = np.array([[0.36, 0.48, -0.80], [-0.80, 0.60, 0.0], [0.48, 0.64, 0.60]])
"""A rotation."""
SHIFT = np.array([31.0, -17.0, 53.0])
Run = tuple[Rehearsal, list[Passed]]
"""A rehearsal at its end, and its steps."""
Other = Callable[[Callable[..., Scene], Rehearsal, np.ndarray], Run]
"""Runs the changed knot, from its scene with overrides, the first run and the tied positions."""
MIRROR = np.diag([1.0, 1.0, -1.0])


def cases(*, small: bool = False) -> list[Case]:
    """See `hard.hard_cases`."""
    scene = _scene(small)
    tight, loose = 1e-6, 0.05 if small else 0.01

    def case(variant: str, title: str, other: Other, limit: float):
        return hard_case(NAME, variant, title, partial(_compare, other, limit, small), scene, small=small)

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
def _unchanged(small: bool) -> tuple[Rehearsal, np.ndarray, list[Passed]]:
    """The knot that all others are compared with: at its end, tied positions, steps."""
    first = Rehearsal(_scene(small))
    x = first.tied()
    first.forget()
    return first, x, list(first.run(x))


def _compare(other: Other, limit: float, small: bool) -> Sequence[Quantity]:
    first, x, passed = _unchanged(small)
    changed, passed_changed = other(partial(_scene, small), first, x)
    displacement, force = force_curve(passed)
    there, found = force_curve(passed_changed)
    scale = float(np.abs(force).max())
    apart = float(np.abs(found - force).max()) / scale
    return [
        *figures_of(changed).quantities(before="3_1", after="3_1"),
        Quantity("same displacements, mm", float(np.abs(there - displacement).max()), 1e-9, kind="at most"),
        Quantity("largest difference of the force over the force", apart, limit, kind="at most"),
        Quantity("largest force, N", scale, 0.01, kind="at least"),
    ]


def _direction(vector: np.ndarray) -> str:
    return f"steps.1.ends.rod.start.direction={vector.tolist()}"


def _pulled_along(scene: Scene) -> np.ndarray:
    end = scene.steps[1].ends["rod"].start
    assert isinstance(end, Driven)
    return np.array(end.direction)


def _moved(scene: Callable[..., Scene], first: Rehearsal, x: np.ndarray) -> Run:
    moved = Rehearsal(scene(_direction(Q @ _pulled_along(first.model.scene))))
    return moved, list(moved.run(x @ Q.T + SHIFT))


def _mirrored(scene: Callable[..., Scene], first: Rehearsal, x: np.ndarray) -> Run:
    section = first.model.body.rods[0].mesh.section
    twin = twins(section.points, section.points * [1.0, -1.0])
    mirrored = Rehearsal(scene(_direction(MIRROR @ _pulled_along(first.model.scene))))
    sections = x.reshape(-1, len(section.points), 3)
    return mirrored, list(mirrored.run((sections[:, twin] @ MIRROR).reshape(-1, 3)))


def _renumbered(scene: Callable[..., Scene], first: Rehearsal, x: np.ndarray) -> Run:
    section = first.model.body.rods[0].mesh.section
    last = len(section.points) - 1
    reverse = Section(section.points[::-1].copy(), last - section.quads[::-1], last - section.axis, last - section.ring)
    renumbered = Rehearsal(scene(), reverse)
    return renumbered, list(renumbered.run(x.reshape(-1, last + 1, 3)[:, ::-1].reshape(-1, 3)))


def _turned(scene: Callable[..., Scene], first: Rehearsal, x: np.ndarray) -> Run:
    section = first.model.body.rods[0].mesh.section
    angle = np.pi / section.sides
    c, s = np.cos(angle), np.sin(angle)
    points = section.points @ np.array([[c, s], [-s, c]])
    turned = Rehearsal(scene(), Section(points, section.quads, section.axis, section.ring))
    tied = turned.tied()
    turned.forget()
    return turned, list(turned.run(tied))


def twins(points: np.ndarray, images: np.ndarray) -> np.ndarray:
    """For each image the point that lies there, shape [n].

    Args:
        points: shape [n, 2].
        images: shape [n, 2].
    """
    distance = np.linalg.norm(points[None] - images[:, None], axis=2)
    assert distance.min(axis=1).max() < 1e-6, "the section is not its own mirror image"
    return distance.argmin(axis=1)
