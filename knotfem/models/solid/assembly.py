"""The terms that a scene calls for, on hexahedra."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.models.base import Obstacle
from knotfem.models.conditions import drag_of, gravity_of, numerical_drag_of
from knotfem.models.effects import CONTACT, INERTIA, rod_friction
from knotfem.models.shared_terms import ContactParts, contact_terms, mass_terms, viscous_drag
from knotfem.models.solid.body import Body
from knotfem.solver.term import Term


def make_terms(body: Body, obstacles: Sequence[Obstacle] = ()) -> list[Term]:
    """Terms of a scene, in the order in which they are assembled; an absent one is not imported and holds no memory.

    Args:
        body: rods.
        obstacles: of the scene and of the user's own.

    Raises:
        InputError: obstacles without contact.
    """
    scene = body.scene
    return [
        *body.elastic,
        *mass_terms(
            lambda: body.mass,
            inertia=INERTIA.wanted(scene),
            drag=drag_of(scene),
            numerical_drag=numerical_drag_of(scene),
            gravity=gravity_of(scene),
        ),
        *contact_terms(_contact_parts(body) if CONTACT.wanted(scene) else None, obstacles),
        *viscous_drag(scene, *body.axis_edges),
    ]


def _contact_parts(body: Body) -> ContactParts:
    from knotfem.contact.law import Penalty
    from knotfem.contact.tube import make_samples, make_tubes
    from knotfem.contact.tube_pairs import TubeSurface

    def friction():
        from knotfem.contact.tube_friction import TubeFriction

        return TubeFriction(stick)

    def obstacle_friction():
        from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction

        return TubeObstacleFriction(stick)

    scene = body.scene
    tubes = make_tubes(
        [rod.mesh.ring_nodes + rod.first for rod in body.rods],
        [rod.axis_nodes for rod in body.rods],
        [rod.target.slices for rod in body.rods],
        [rod.mesh.radius for rod in body.rods],
        [rod.mesh.radius * rod.mesh.node_scale for rod in body.rods],
    )
    c, d = scene.contact, scene.diameter
    law = Penalty(c.stiffness_over_modulus * scene.youngs_modulus / d, c.ramp_over_diameter * d, c.onset_over_ramp)
    stick = c.stick_over_diameter * d
    samples = make_samples(tubes, c.sample_spacing_over_diameter * d)
    return ContactParts(TubeSurface(tubes), samples, law, law, rod_friction(scene), friction, obstacle_friction)
