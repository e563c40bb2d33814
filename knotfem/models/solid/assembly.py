"""The effects that a scene calls for, and the system of equations of each of its steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from knotfem.models.conditions import (
    adjust,
    dead_load,
    following_load,
    make_scheme,
    ramp,
    reported_first,
    turn_angle,
    unit,
)
from knotfem.models.registry import REGISTRY
from knotfem.scene.steps import Clamped, Driven, Loaded, Pinned, Pull, Step, Turn, Turned
from knotfem.solver.constraints import Prescribed, driven, held, turned
from knotfem.solver.system import System
from knotfem.solver.term import Term
from knotfem.sparse.linear import make_solver

if TYPE_CHECKING:
    from knotfem.models.solid.body import Body, RodBody


@dataclass(eq=False)
class Model:
    """Effects that outlive a step, in the order in which they are assembled.

    Attributes:
        body: rods.
        effects: bulk and core first.
        absent: effects that the scene does not call for, each with why.
    """

    body: Body
    effects: list[Term]
    absent: dict[str, str] = field(default_factory=dict)

    def named(self, name: str) -> list:
        """All effects of a name."""
        return [effect for effect in self.effects if effect.name == name]


def build_model(body: Body) -> Model:
    """Effects of a scene; an absent one is not imported, holds no memory and is not visited."""
    model = Model(body, list(body.elastic))
    for registered in REGISTRY:
        reason = registered.absent(body.scene)
        if reason:
            model.absent[registered.name] = reason
        elif registered.make is not None:
            model.effects.extend(registered.make(import_module(registered.module), model))
    return model


@dataclass(eq=False)
class StepSystem:
    """A system with what its step prescribes.

    Attributes:
        system: effects and constraints.
        supports: nodes of each held or driven end, by its label.
        drives: label, nodes and unit direction of each driven or loaded end, the first being the one that is reported.
    """

    system: System
    supports: dict[str, np.ndarray]
    drives: list[tuple[str, np.ndarray, np.ndarray]]


def step_system(
    model: Model, step: Step, start: float, x: np.ndarray, before: dict[str, np.ndarray], threads: int
) -> StepSystem:
    """Equations of a step.

    Args:
        model: effects.
        step: what happens to the ends.
        start: time at which the step begins [s].
        x: positions at that time [mm], shape [nodes, 3].
        before: force on each loaded end when the step begins [N], by label, shape [3]; none for an end that bore none.
        threads: of the linear solver.
    """
    prescribed: list[Prescribed] = []
    loads: list[Term] = []
    drives: list[tuple[str, np.ndarray, np.ndarray]] = []
    for rod in model.body.rods:
        for side in ("start", "end"):
            _add_end(rod, side, step, start, x, before, prescribed, loads, drives)
    adjust(model.named, model.body.scene, step, start)
    solver = make_solver(model.body.scene.solver.linear, threads)
    scheme = make_scheme(model.body.scene, step)
    system = System([*model.effects, *loads], model.body.nodes, solver, scheme, prescribed, model.body.shift_weights)
    return StepSystem(system, {motion.label: motion.nodes for motion in prescribed}, reported_first(drives, step))


def _add_end(rod: RodBody, side: str, step: Step, start, x, before, prescribed, loads, drives) -> None:
    end = getattr(step.ends[rod.scene.name], side)
    label = f"{rod.scene.name}.{side}"
    nodes = rod.end_nodes(side)
    axis = nodes[rod.mesh.section.axis]
    match end:
        case Clamped():
            prescribed.append(held(nodes, x[nodes], label))
        case Pinned():
            prescribed.append(held(nodes[[rod.mesh.section.axis]], x[[axis]], label))
        case Driven():
            assert isinstance(step, Pull)
            direction = unit(end.direction)
            prescribed.append(driven(nodes, x[nodes], direction, ramp(step, start), label))
            drives.append((label, nodes, direction))
        case Turned():
            assert isinstance(step, Turn)
            across = x[nodes[rod.mesh.section.ring]] - x[axis]
            tangent = unit(np.cross(across, np.roll(across, -1, axis=0)).sum(axis=0))
            angle = turn_angle(end.turns, step, start)
            prescribed.append(turned(nodes, x[nodes], x[axis], tangent, angle, label))
        case Loaded():
            from knotfem.terms.load import EndForce, FollowingForce

            bore = before.get(label, np.zeros(3))
            if end.following:
                other = rod.axis_nodes[1 if side == "start" else -2]
                history = following_load(end, x[axis] - x[other], label, bore, step, start)
                loads.append(FollowingForce(nodes, rod.end_weights(), int(other), int(axis), history))
            else:
                loads.append(EndForce(nodes, rod.end_weights(), dead_load(end, bore, step, start)))
            drives.append((label, nodes, unit(end.direction)))
