"""The effects that a scene may call for, and why it does without one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from knotfem.scene.effects import Inertia
from knotfem.scene.model import Scene
from knotfem.scene.steps import Loaded


@dataclass(frozen=True)
class Effect:
    """An effect that a scene may call for.

    Attributes:
        name: of its terms.
        absent: why a scene does without; "" where it calls for it.
    """

    name: str
    absent: Callable[[Scene], str]

    def wanted(self, scene: Scene) -> bool:
        """Whether a scene calls for it."""
        return not self.absent(scene)


def _no_core(scene: Scene) -> str:
    return "" if any(rod.core is not None for rod in scene.rods) else "no rod has one"


def _no_real_time(scene: Scene) -> str:
    return "" if any(step.real for step in scene.steps) else "no step goes in real time"


def _no_damping(scene: Scene) -> str:
    if all(rod.material.relaxation_time == 0.0 for rod in scene.rods):
        return "no rod has a relaxation time"
    return _no_real_time(scene)


def _no_inertia(scene: Scene) -> str:
    if reason := _no_real_time(scene):
        return reason
    return 'inertia.scheme is "quasi-static"' if scene.inertia.scheme == "quasi-static" else ""


def _no_drag(scene: Scene) -> str:
    if scene.drag is None:
        return "not in the scene"
    if max(scene.drag.rate_of(False), scene.drag.rate_of(True)) == 0.0:
        return "its rate is 0"
    return _no_real_time(scene)


def _no_numerical_drag(scene: Scene) -> str:
    return "" if any(not step.real for step in scene.steps) else "all steps go in real time"


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


def _no_viscous_drag(scene: Scene) -> str:
    drag = scene.effects.viscous_drag
    if drag is None:
        return "not in the scene"
    if drag.normal == 0.0 and drag.tangential == 0.0:
        return "both coefficients are 0"
    return _no_real_time(scene)


def _no_load(scene: Scene) -> str:
    return "" if any(step.having(Loaded) for step in scene.steps) else "no step loads an end"


CORE = Effect("core", _no_core)
DAMPING = Effect("internal damping", _no_damping)
INERTIA = Effect("inertia", _no_inertia)
DRAG = Effect("drag", _no_drag)
NUMERICAL_DRAG = Effect("numerical_drag", _no_numerical_drag)
GRAVITY = Effect("gravity", _no_gravity)
CONTACT = Effect("contact", _no_contact)
FRICTION = Effect("friction", _no_friction)
CYLINDER = Effect("cylinder", _no_cylinder)
CYLINDER_FRICTION = Effect("cylinder friction", _no_cylinder_friction)
VISCOUS_DRAG = Effect("viscous_drag", _no_viscous_drag)
LOAD = Effect("load", _no_load)
EFFECTS = (
    CORE, DAMPING, INERTIA, DRAG, NUMERICAL_DRAG, GRAVITY, CONTACT, FRICTION, CYLINDER, CYLINDER_FRICTION,
    VISCOUS_DRAG, LOAD,
)  # fmt: skip


def absent_effects(scene: Scene) -> dict[str, str]:
    """Effects that a scene does not call for, each with why."""
    return {effect.name: reason for effect in EFFECTS if (reason := effect.absent(scene))}


def rod_friction(scene: Scene) -> np.ndarray:
    """Coefficients of the rods on each other, shape [rods, rods]."""
    names = [rod.name for rod in scene.rods]
    return np.array([[scene.friction_between(a, b) for b in names] for a in names])


def obstacle_friction(scene: Scene) -> np.ndarray:
    """Coefficients of the rods on each obstacle, shape [obstacles, rods]."""
    return np.array([[scene.friction_between(rod.name, o.name) for rod in scene.rods] for o in scene.obstacles])


def idle_effects(scene: Scene) -> list[str]:
    """Warnings of what a scene gives and no step takes up, since none goes in real time."""
    if any(step.real for step in scene.steps) or not scene.steps:
        return []
    given = {
        "drag": scene.drag is not None,
        "inertia": scene.inertia != Inertia(),
        "effects.viscous_drag": scene.effects.viscous_drag is not None,
        "rods.material.relaxation_time": any(rod.material.relaxation_time > 0.0 for rod in scene.rods),
    }
    return [
        f'{key} changes nothing: it acts in real time only, and no step has rate = "real"'
        for key, there in given.items()
        if there
    ]
