"""All effects that a scene may call for besides elasticity: when each is absent, and how it is made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.models.conditions import gravity_of
from knotfem.scene.model import Scene
from knotfem.scene.registered import settings_of
from knotfem.scene.steps import Loaded
from knotfem.solver.term import Term
from knotfem.terms.registry import INTERNAL_DAMPING, REGISTERED, module_of

if TYPE_CHECKING:
    from knotfem.models.solid.assembly import Model

Make = Callable[[Any, "Model"], Sequence[Term]]
"""Effects of a model from their imported module and the effects before them."""


@dataclass(frozen=True)
class Registered:
    """An effect that a scene may call for.

    Attributes:
        name: under which it is assembled, timed and listed.
        module: imported only where the scene calls for the effect.
        absent: why a scene does without; "" where it calls for it.
        make: the effects; None where they belong to the rods or to a step.
    """

    name: str
    module: str
    absent: Callable[[Scene], str]
    make: Make | None


def _no_core(scene: Scene) -> str:
    return "" if any(rod.core is not None for rod in scene.rods) else "no rod has one"


def _no_damping(scene: Scene) -> str:
    return "" if any(rod.material.relaxation_time > 0.0 for rod in scene.rods) else "no rod has a relaxation time"


def _no_inertia(scene: Scene) -> str:
    return 'inertia.scheme is "quasi-static"' if scene.inertia.scheme == "quasi-static" else ""


def _no_drag(scene: Scene) -> str:
    if scene.drag is None:
        return "not in the scene"
    return "" if max(scene.drag.rate_of(False), scene.drag.rate_of(True)) > 0.0 else "its rate is 0"


def _no_gravity(scene: Scene) -> str:
    if scene.gravity is None:
        return "not in the scene"
    return "" if scene.gravity.acceleration > 0.0 else "its acceleration is 0"


def _no_contact(scene: Scene) -> str:
    return "" if scene.contact.enabled else "contact.enabled is false"


def _no_friction(scene: Scene) -> str:
    if not scene.contact.enabled:
        return _no_contact(scene)
    return "" if rod_friction(scene).max() > 0.0 else "all coefficients between rods are 0"


def _no_cylinder(scene: Scene) -> str:
    return _no_contact(scene) or ("" if scene.obstacles else "the scene has no obstacle")


def _no_cylinder_friction(scene: Scene) -> str:
    if reason := _no_cylinder(scene):
        return reason
    return "" if obstacle_friction(scene).max() > 0.0 else "all coefficients of obstacles are 0"


def _no_load(scene: Scene) -> str:
    return "" if any(step.having(Loaded) for step in scene.steps) else "no step loads an end"


def rod_friction(scene: Scene) -> np.ndarray:
    """Coefficients of the rods on each other, shape [rods, rods]."""
    names = [rod.name for rod in scene.rods]
    return np.array([[scene.friction_between(a, b) for b in names] for a in names])


def obstacle_friction(scene: Scene) -> np.ndarray:
    """Coefficients of the rods on each obstacle, shape [obstacles, rods]."""
    return np.array([[scene.friction_between(rod.name, o.name) for rod in scene.rods] for o in scene.obstacles])


def _inertia(module: Any, model: Model) -> Sequence[Term]:
    return [module.Inertia(model.body.mass)]


def _drag(module: Any, model: Model) -> Sequence[Term]:
    drag = model.body.scene.drag
    assert drag is not None
    return [module.Drag(model.body.mass, drag.rate)]


def _gravity(module: Any, model: Model) -> Sequence[Term]:
    return [module.Gravity(model.body.mass, gravity_of(model.body.scene))]


def _contact(module: Any, model: Model) -> Sequence[Term]:
    from knotfem.contact.tube import make_samples, make_tubes

    body, scene = model.body, model.body.scene
    tubes = make_tubes(
        [rod.mesh.ring_nodes + rod.first for rod in body.rods],
        [rod.axis_nodes for rod in body.rods],
        [rod.mesh.element_length for rod in body.rods],
        [rod.mesh.radius for rod in body.rods],
        [rod.mesh.radius * rod.mesh.node_scale for rod in body.rods],
    )
    spacing = scene.contact.sample_spacing_over_diameter * scene.diameter
    return [module.Contact(tubes, make_samples(tubes, spacing), body.law)]


def _friction(module: Any, model: Model) -> Sequence[Term]:
    (contact,) = model.named("contact")
    return [module.Friction(contact, rod_friction(model.body.scene))]


def _cylinder(module: Any, model: Model) -> Sequence[Term]:
    (contact,) = model.named("contact")
    cylinders = []
    for obstacle in model.body.scene.obstacles:
        axis = np.array(obstacle.axis, dtype=float) / np.linalg.norm(obstacle.axis)
        point, radius = np.array(obstacle.point), 0.5 * obstacle.diameter
        cylinders.append(module.Cylinder(contact.samples, model.body.law, point, axis, radius, contact.closing))
    return cylinders


def _cylinder_friction(module: Any, model: Model) -> Sequence[Term]:
    rubbing = []
    pairs = zip(model.named("cylinder"), obstacle_friction(model.body.scene), strict=True)
    for number, (cylinder, mu) in enumerate(pairs, 1):
        if mu.max() > 0.0:
            rubbing.append(module.CylinderFriction(cylinder, mu))
            rubbing[-1].number = number
    return rubbing


def _whole(name: str, module: str) -> Registered:
    """An effect that comes whole in one file, see `knotfem.terms.registry`."""

    def absent(scene: Scene) -> str:
        settings = settings_of(scene.effects, name)
        return "not in the scene" if settings is None else module_of(name).absent(settings)

    def make(imported: Any, model: Model) -> Sequence[Term]:
        settings = settings_of(model.body.scene.effects, name)
        return [imported.make(settings, model.body.rods)]

    return Registered(name, module, absent, make)


REGISTRY: tuple[Registered, ...] = (
    Registered("core", "knotfem.models.solid.core", _no_core, None),
    Registered(INTERNAL_DAMPING, "knotfem.models.rod.damping", _no_damping, None),
    Registered("inertia", "knotfem.terms.inertia", _no_inertia, _inertia),
    Registered("drag", "knotfem.terms.inertia", _no_drag, _drag),
    Registered("gravity", "knotfem.terms.gravity", _no_gravity, _gravity),
    Registered("contact", "knotfem.contact.tube_contact", _no_contact, _contact),
    Registered("friction", "knotfem.contact.tube_friction", _no_friction, _friction),
    Registered("cylinder", "knotfem.contact.tube_cylinder", _no_cylinder, _cylinder),
    Registered("cylinder friction", "knotfem.contact.tube_cylinder", _no_cylinder_friction, _cylinder_friction),
    *(_whole(name, module) for name, module in REGISTERED.items()),
    Registered("load", "knotfem.terms.load", _no_load, None),
)
"""In the order in which they are assembled: an effect stands behind those that it builds on."""
