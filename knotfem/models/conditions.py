"""What a step does to ends and friction, as functions of time, whatever the rods are modelled by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.vectors import unit
from knotfem.models.effects import DRAG, NUMERICAL_DRAG
from knotfem.scene.model import Scene
from knotfem.scene.steps import Load, Loaded, Pull, Relax, Step, Turn
from knotfem.solver import schemes
from knotfem.solver.constraints import Clamp
from knotfem.solver.stepping.quasi_static import DRAG_RATE
from knotfem.solver.term import Conditions
from knotfem.types import History

Size = TypeVar("Size", float, np.ndarray)


def gravity_of(scene: Scene) -> np.ndarray:
    """Acceleration [mm/s^2], shape [3]; zero where the scene has none."""
    gravity = scene.gravity
    return np.zeros(3) if gravity is None else gravity.acceleration * unit(gravity.direction)


def drag_of(scene: Scene) -> float | None:
    """Rate of the drag on the mass in real time [1/s] where a step gives none; None where no step has drag."""
    return scene.drag.rate if scene.drag is not None and DRAG.wanted(scene) else None


def numerical_drag_of(scene: Scene) -> float | None:
    """Rate of the numerical drag [1/s]; None where all steps go in real time."""
    return DRAG_RATE if NUMERICAL_DRAG.wanted(scene) else None


def ramp(step: Pull, start: float) -> History:
    """Displacement of the driven ends [mm] in a step that begins at `start` [s]."""
    return lambda time: min(step.nominal_speed * (time - start), step.displacement)


def turn_angle(turns: float, step: Turn, start: float) -> History:
    """Angle of a turned end [rad] in a step that begins at `start` [s]."""
    return lambda time: 2.0 * np.pi * turns * min(1.0, (time - start) / step.duration)


def force_history(force: Size, before: Size, step: Step, start: float) -> Callable[[float], Size]:
    """Force on a loaded end [N], a number or a vector, which was `before` when the step began at `start` [s]."""
    if not isinstance(step, Load):
        return lambda time: force
    return lambda time: before + (force - before) * min(1.0, (time - start) / step.duration)


def dead_load(end: Loaded, before: np.ndarray, step: Step, start: float) -> Callable[[float], np.ndarray]:
    """Force on an end [N], shape [3], as a function of time [s], on which `before` acted when the step began."""
    return force_history(end.force * unit(end.direction), before, step, start)


def following_load(
    end: Loaded, outward: np.ndarray, label: str, before: np.ndarray, step: Step, start: float
) -> History:
    """Force on an end along its own tangent, positive outwards [N]; see `dead_load` and `following_sign`."""
    outward = unit(outward)
    sign = following_sign(unit(end.direction), outward, label)
    return force_history(sign * end.force, float(before @ outward), step, start)


def following_sign(direction: np.ndarray, outward: np.ndarray, label: str) -> float:
    """Sign of a following force that at first acts along `direction`.

    Args:
        direction: unit vector, shape [3].
        outward: unit vector, of the rod at its end, shape [3].
        label: of the end, such as "rod.start".

    Raises:
        InputError: the direction is across the rod.
    """
    along = float(outward @ direction)
    if abs(along) < 0.5:
        raise InputError(
            "a following force acts along the end's tangent",
            key=f"steps.ends.{label}.direction",
            found=str(direction.tolist()),
            expected=f"near +-{np.round(outward, 3).tolist()}",
        )
    return 1.0 if along > 0.0 else -1.0


def friction_factor(scene: Scene, step: Step, start: float) -> History | None:
    """By what the coefficients between rods are multiplied in a step that begins at `start` [s].

    A step without a schedule keeps what the last one before it ended with; None where there was none.
    """
    names = [other.name for other in scene.steps]
    scheduled = [other for other in scene.steps[: names.index(step.name) + 1] if other.friction_schedule]
    if not scheduled:
        return None
    schedule = scheduled[-1].friction_schedule
    factors = np.array([point.friction for point in schedule]) / scene.contact.friction
    if scheduled[-1] is not step:
        return lambda time: float(factors[-1])
    times = np.array([point.time for point in schedule]) + start
    return lambda time: float(np.interp(time, times, factors))


def make_scheme(scene: Scene, step: Step) -> schemes.Scheme:
    """Time integration scheme of a step."""
    if not step.real:
        return schemes.Scheme()
    kinds: dict[str, Callable[[], schemes.Scheme]] = {
        "quasi-static": schemes.Scheme,
        "backward-euler": schemes.BackwardEuler,
        "hht": lambda: schemes.hht(scene.inertia.hht_alpha),
        "generalised-alpha": lambda: schemes.generalised_alpha(scene.inertia.spectral_radius),
    }
    return kinds[scene.inertia.scheme_of(isinstance(step, Relax))]()


def drag_rate(scene: Scene, step: Step) -> float:
    """Rate of drag [1/s] in a step in real time; 0 where the scene has none."""
    return 0.0 if scene.drag is None else scene.drag.rate_of(isinstance(step, Relax))


def conditions_of(scene: Scene, step: Step, start: float, clamps: Sequence[Clamp] = ()) -> Conditions:
    """Friction and drag of a step that begins at `start` [s], with the clamps of its ends."""
    frozen = isinstance(step, Relax) and step.frozen
    return Conditions(
        friction_factor(scene, step, start), drag_rate(scene, step), clamps, real=step.real, frictionless=frozen
    )
