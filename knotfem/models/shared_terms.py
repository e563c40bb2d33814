"""Terms that both models have; an absent one is not imported and holds no memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knotfem.errors import InputError
from knotfem.models.base import Obstacle
from knotfem.models.effects import CYLINDER, VISCOUS_DRAG, obstacle_friction
from knotfem.scene.model import Scene
from knotfem.solver.term import Term

if TYPE_CHECKING:  # with compiled loops, for scenes with contact only
    from knotfem.contact.friction import FrictionLaw
    from knotfem.contact.law import Penalty
    from knotfem.contact.samples import Samples
    from knotfem.contact.surface import Surface


def mass_terms(
    mass: Callable[[], np.ndarray],
    *,
    inertia: bool,
    drag: float | None,
    numerical_drag: float | None,
    gravity: np.ndarray | None,
) -> list[Term]:
    """Inertia, and drag and weight of the mass.

    Args:
        mass: makes the lumped mass [tonne], shape [nodes] or [nodes, width]; called where a term needs it.
        inertia: whether there is any.
        drag: rate in real time [1/s]; None without drag.
        numerical_drag: rate in quasi-static steps [1/s]; None where there is none.
        gravity: acceleration [mm/s^2], shape [3]; None or zero without weight.
    """
    terms: list[Term] = []
    if inertia or drag is not None or numerical_drag is not None:
        from knotfem.terms.inertia import Drag, Inertia, NumericalDrag

        if inertia:
            terms.append(Inertia(mass()))
        if drag is not None:
            terms.append(Drag(mass(), drag))
        if numerical_drag is not None:
            terms.append(NumericalDrag(mass(), numerical_drag))
    if gravity is not None and np.any(gravity):
        from knotfem.terms.gravity import Gravity

        lumped = mass()
        terms.append(Gravity(lumped if lumped.ndim == 1 else lumped[:, 0], np.asarray(gravity, dtype=float)))
    return terms


def viscous_drag(scene: Scene, edges: np.ndarray, lengths: np.ndarray) -> list[Term]:
    """Drag of a fluid on the centrelines, where the scene calls for it.

    Args:
        scene: what the user asked for.
        edges: nodes of each edge of the centrelines, shape [edges, 2].
        lengths: of the edges when free of stress [mm], shape [edges].
    """
    if not VISCOUS_DRAG.wanted(scene):
        return []
    from knotfem.terms.viscous import ViscousDrag

    drag = scene.effects.viscous_drag
    assert drag is not None
    return [ViscousDrag(edges, lengths, drag.normal, drag.tangential)]


def obstacles_of(scene: Scene, own: Sequence[Obstacle] = ()) -> list[Obstacle]:
    """Cylinders of a scene with contact, then the obstacles of the user's own."""
    if not CYLINDER.wanted(scene):
        return list(own)
    from knotfem.contact.rigid import make_cylinder

    cylinders = [
        Obstacle(make_cylinder(np.array(o.point), np.array(o.axis), 0.5 * o.diameter), mu, o.name)
        for o, mu in zip(scene.obstacles, obstacle_friction(scene), strict=True)
    ]
    return [*cylinders, *own]


@dataclass(frozen=True, eq=False)
class ContactParts:
    """What contact of all rods is made of.

    Attributes:
        surface: of all rods.
        samples: of it.
        law: normal law between rods.
        obstacle_law: normal law on obstacles.
        friction: mu of each pair of rods, shape [rods, rods].
        make_friction: makes the friction law between rods; called where a coefficient is above 0.
        make_obstacle_friction: the same on obstacles.
    """

    surface: Surface
    samples: Samples
    law: Penalty
    obstacle_law: Penalty
    friction: np.ndarray
    make_friction: Callable[[], FrictionLaw]
    make_obstacle_friction: Callable[[], FrictionLaw]


def contact_terms(parts: ContactParts | None, obstacles: Sequence[Obstacle]) -> list[Term]:
    """Contact and friction of rods on each other and on obstacles.

    Args:
        parts: None for rods that pass through each other.
        obstacles: rigid bodies.

    Raises:
        InputError: obstacles without contact.
    """
    if parts is None:
        if obstacles:
            raise InputError("obstacles need contact", key="contact.enabled", found="false", expected="true")
        return []
    from knotfem.contact.pairs import PairContact

    contact = PairContact(parts.surface, parts.samples, parts.law)
    terms: list[Term] = [contact]
    if parts.friction.max() > 0.0:
        from knotfem.contact.friction import Friction

        terms.append(Friction(contact, parts.make_friction(), parts.friction))
    for number, obstacle in enumerate(obstacles, 1):
        terms += _obstacle_terms(parts, obstacle, number)
    return terms


def _obstacle_terms(parts: ContactParts, obstacle: Obstacle, number: int) -> list[Term]:
    from knotfem.contact.obstacle import ObstacleContact

    contact = ObstacleContact(parts.surface, parts.samples, parts.obstacle_law, obstacle.surface, number)
    mu = np.broadcast_to(np.asarray(obstacle.friction, dtype=float), len(parts.friction)).copy()
    if mu.max() == 0.0:
        return [contact]
    from knotfem.contact.friction import Friction

    return [contact, Friction(contact, parts.make_obstacle_friction(), mu, scheduled=False)]
