"""The terms that a scene calls for, on hexahedra."""

from __future__ import annotations

import numpy as np

from knotfem.errors import InputError
from knotfem.models.base import Obstacle
from knotfem.models.conditions import gravity_of
from knotfem.models.effects import (
    CONTACT,
    CYLINDER,
    DRAG,
    FRICTION,
    GRAVITY,
    INERTIA,
    VISCOUS_DRAG,
    obstacle_friction,
    rod_friction,
)
from knotfem.models.solid.body import Body
from knotfem.solver.term import Term


def make_terms(body: Body, obstacles: tuple[Obstacle, ...] = ()) -> list[Term]:
    """Terms of a scene, in the order in which they are assembled; an absent one is not imported and holds no memory.

    Args:
        body: rods.
        obstacles: of the user's own.

    Raises:
        InputError: obstacles without contact.
    """
    scene = body.scene
    terms = body.elastic
    if INERTIA.wanted(scene):
        from knotfem.terms.inertia import Inertia

        terms.append(Inertia(body.mass))
    if DRAG.wanted(scene):
        from knotfem.terms.inertia import Drag

        terms.append(Drag(body.mass))
    if GRAVITY.wanted(scene):
        from knotfem.terms.gravity import Gravity

        terms.append(Gravity(body.mass, gravity_of(scene)))
    if CONTACT.wanted(scene):
        terms += _contact_terms(body, obstacles)
    elif obstacles:
        raise InputError("obstacles need contact", key="rods")
    if VISCOUS_DRAG.wanted(scene):
        terms.append(_viscous_drag(body))
    return terms


def _contact_terms(body: Body, obstacles: tuple[Obstacle, ...]) -> list[Term]:
    from knotfem.contact.law import Penalty
    from knotfem.contact.pairs import PairContact
    from knotfem.contact.tube import make_samples, make_tubes
    from knotfem.contact.tube_pairs import TubeSurface

    scene = body.scene
    tubes = make_tubes(
        [rod.mesh.ring_nodes + rod.first for rod in body.rods],
        [rod.axis_nodes for rod in body.rods],
        [rod.mesh.element_length for rod in body.rods],
        [rod.mesh.radius for rod in body.rods],
        [rod.mesh.radius * rod.mesh.node_scale for rod in body.rods],
    )
    c, d = scene.contact, scene.diameter
    law = Penalty(c.stiffness_over_modulus * scene.youngs_modulus / d, c.ramp_over_diameter * d)
    stick = c.stick_over_diameter * d
    surface, samples = TubeSurface(tubes), make_samples(tubes, c.sample_spacing_over_diameter * d)
    contact = PairContact(surface, samples, law)
    terms: list[Term] = [contact]
    if FRICTION.wanted(scene):
        from knotfem.contact.friction import Friction
        from knotfem.contact.tube_friction import TubeFriction

        terms.append(Friction(contact, TubeFriction(stick), rod_friction(scene)))
    if not CYLINDER.wanted(scene) and not obstacles:
        return terms
    from knotfem.contact.obstacle import ObstacleContact
    from knotfem.contact.rigid import make_cylinder

    bodies = [make_cylinder(np.array(o.point), np.array(o.axis), 0.5 * o.diameter) for o in scene.obstacles]
    coefficients = [*obstacle_friction(scene), *(np.full(len(body.rods), o.friction) for o in obstacles)]
    touching = [ObstacleContact(surface, samples, law, rigid) for rigid in [*bodies, *(o.surface for o in obstacles)]]
    terms += touching
    for number, (contact, mu) in enumerate(zip(touching, coefficients, strict=True), 1):
        if mu.max() > 0.0:
            from knotfem.contact.friction import Friction
            from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction

            terms.append(Friction(contact, TubeObstacleFriction(stick), mu, scheduled=False))
            terms[-1].number = number
    return terms


def _viscous_drag(body: Body) -> Term:
    from knotfem.terms.viscous import ViscousDrag

    drag = body.scene.effects.viscous_drag
    assert drag is not None
    axes = [rod.axis_nodes for rod in body.rods]
    edges = np.concatenate([np.stack([axis[:-1], axis[1:]], axis=1) for axis in axes])
    lengths = np.concatenate(
        [np.full(axis.size - 1, rod.mesh.length / (axis.size - 1)) for axis, rod in zip(axes, body.rods, strict=True)]
    )
    return ViscousDrag(edges, lengths, drag.normal, drag.tangential)
