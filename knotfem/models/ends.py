"""What a step of a scene does to the ends of the rods: one dispatch for all models."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.geometry.vectors import unit
from knotfem.models.base import SIDES, Model, RigidMotion
from knotfem.models.conditions import dead_load, following_load, ramp, turn_angle
from knotfem.scene.steps import AnyEnd, Clamped, Driven, Free, Loaded, Pinned, Pull, Relax, Step, Turn, Turned
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.state import State
from knotfem.solver.term import Term

Drive = tuple[str, np.ndarray, np.ndarray]
"""Label, nodes and unit direction of an end that is driven or loaded."""


@dataclass(eq=False)
class Ends:
    """Constraints and loads of all ends.

    Attributes:
        prescribed: nodes whose places are given.
        clamps: ends of discrete rods whose orientation is given.
        loads: forces.
        drives: driven and loaded ends, the first being the one that tables report: the first driven one, else the first
            loaded one. In a step that has none, the one reported before, if it is held.
    """

    prescribed: list[Prescribed] = field(default_factory=list)
    clamps: list[Clamp] = field(default_factory=list)
    loads: list[Term] = field(default_factory=list)
    drives: list[Drive] = field(default_factory=list)

    @property
    def supports(self) -> dict[str, np.ndarray]:
        """Nodes of each held or driven end by its label."""
        return {motion.label: motion.nodes for motion in self.prescribed if motion.label}


def ends_of(model: Model, step: Step, origin: State, before: dict[str, np.ndarray]) -> Ends:
    """Constraints and loads of a step; arguments as for `Model.equations`."""
    ends = Ends()
    for rod, scene in enumerate(model.rods):
        for side in SIDES:
            end = getattr(step.ends[scene.name], side)
            label = model.end_label(rod, side)
            if isinstance(end, Loaded):
                _add_load(ends, model, (rod, side), end, label, step, origin, before.get(label, np.zeros(3)))
            elif not isinstance(end, Free):
                _add_constraint(ends, model, (rod, side), end, step, origin)
    if isinstance(step, Relax) and step.frozen:
        ends.prescribed += [_frozen(model, rod, origin) for rod in range(len(model.rods))]
    if not ends.drives:
        ends.drives += _still_reported(model, step, ends.supports)
    driven = ends.supports
    ends.drives.sort(key=lambda drive: drive[0] not in driven)
    return ends


def _still_reported(model: Model, step: Step, supports: dict[str, np.ndarray]) -> list[Drive]:
    """The end that the steps before have driven or loaded last, where it is held now."""
    names = [each.name for each in model.scene.steps]
    for earlier in reversed(model.scene.steps[: names.index(step.name)]):
        moved = [*earlier.having(Driven), *earlier.having(Loaded)]
        if not moved:
            continue
        name, side = moved[0]
        rod = [each.name for each in model.rods].index(name)
        label, end = model.end_label(rod, side), getattr(earlier.ends[name], side)
        return [(label, supports[label], unit(end.direction))] if label in supports else []
    return []


def _frozen(model: Model, rod: int, origin: State) -> Prescribed:
    """The centreline of a rod, which stays where it is."""
    nodes = model.axis_nodes(rod)
    places = origin.x[nodes, :3].copy()
    return Prescribed(nodes, lambda time: places)


def _add_constraint(ends: Ends, model: Model, place: tuple[int, str], end: AnyEnd, step: Step, origin: State) -> None:
    prescribed, clamps = model.constrained(*place, rigid_motion(end, step, origin.time), origin)
    ends.prescribed.append(prescribed)
    ends.clamps += clamps
    if isinstance(end, Driven):
        ends.drives.append((prescribed.label, prescribed.nodes, unit(end.direction)))


def rigid_motion(end: AnyEnd, step: Step, start: float) -> RigidMotion:
    """Motion of an end that is held, driven or turned in a step that begins at `start` [s]."""
    match end:
        case Clamped():
            return RigidMotion()
        case Pinned():
            return RigidMotion(oriented=False)
        case Driven():
            assert isinstance(step, Pull)
            path, direction = ramp(step, start), unit(end.direction)
            return RigidMotion(translation=lambda time: path(time) * direction)
        case Turned():
            assert isinstance(step, Turn)
            return RigidMotion(rotation=turn_angle(end.turns, step, start))
    raise TypeError(f"no rigid motion: {end}")


def _add_load(
    ends: Ends,
    model: Model,
    place: tuple[int, str],
    end: Loaded,
    label: str,
    step: Step,
    origin: State,
    before: np.ndarray,
) -> None:
    from knotfem.terms.load import EndForce, FollowingForce

    at = model.end_nodes(*place)
    if end.following:
        history = following_load(end, model.outward(*place, origin), label, before, step, origin.time)
        ends.loads.append(FollowingForce(at.nodes, at.weights, at.inner, at.outer, history))
    else:
        ends.loads.append(EndForce(at.nodes, at.weights, dead_load(end, before, step, origin.time)))
    ends.drives.append((label, at.nodes, unit(end.direction)))
