"""The steps of a scene in memory, from any state and on any section, for cases that a run directory cannot hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from knotfem.energy.account import Balance
from knotfem.geometry.frames import tangents
from knotfem.mesh.section import Section
from knotfem.models.solid.solid import Solid
from knotfem.run.monitor import KnotWatch
from knotfem.run.stepping import AtRest, march_of
from knotfem.scene.model import Scene
from knotfem.scene.steps import Relax, Release, Step
from knotfem.solver.stepping.integrator import Accepted, Progress
from knotfem.solver.term import Motion
from knotfem.sparse.linear import available
from knotfem.topology.knot_type import knot_type


@dataclass(frozen=True)
class Passed:
    """An accepted step.

    Attributes:
        step: of the scene.
        accepted: what the march took.
        balance: what it is held against.
        missing: work that is neither stored nor dissipated so far [N mm].
    """

    step: Step
    accepted: Accepted
    balance: Balance
    missing: float

    @property
    def x(self) -> np.ndarray:
        """Positions [mm], shape [nodes, 3]."""
        return self.accepted.motion.x


class Rehearsal:
    """A scene of hexahedra, tied in memory.

    Args:
        scene: what to run.
        section: of all rods, instead of the shipped one.

    Attributes:
        model: of the scene.
        jacobian: smallest determinant of the deformation gradient so far.
        penetration: deepest so far [mm].
        cutbacks: failed attempts so far.
        steps: accepted so far.
        missing: largest missing energy so far, relaxing not counted [N mm].
        turned_over: largest of work, stored energy and what was taken so far, likewise [N mm].
        before: knots that the steps set out from, as `knots` names them.
    """

    def __init__(self, scene: Scene, section: Section | None = None) -> None:
        self.model = Solid(scene, section)
        self.jacobian, self.penetration = 1.0, 0.0
        self.cutbacks = self.steps = 0
        self.missing = self.turned_over = 0.0
        self.before = ""
        self.account = self.model.account()

    def tied(self) -> np.ndarray:
        """Map the centrelines; positions [mm], shape [nodes, 3]."""
        scene = self.model.scene
        solver = available()[0] if scene.solver.linear == "auto" else scene.solver.linear
        x = np.zeros((self.model.body.nodes, 3))
        for increment in self.model.mapping(self.model.paths(), solver):
            x = increment.x
        return x

    def forget(self) -> None:
        """Set the elements' own unknowns back to those of an unstressed rod; the next solve finds them anew."""
        for rod in self.model.body.rods:
            rod.bulk.forget()
            if rod.core is not None:
                rod.core.force[:] = 0.0

    def run(self, x: np.ndarray) -> Iterator[Passed]:
        """All steps of the scene from rest at x [mm], shape [nodes, 3].

        Raises:
            KnotfemError: what would end a run.
        """
        motion = Motion.at_rest(x)
        self._x = x
        self._ends = [(-t[0], t[-1]) for t in map(tangents, self.model.centrelines(x))]
        self.before = self.knots()
        for number, step in enumerate(self.model.scene.steps):
            anew = number <= len(self.model.scene.tying_steps)
            for passed in self._take(step, motion, anew=anew):
                motion = passed.accepted.motion
                yield passed

    def knots(self) -> str:
        """Names of the rods' knots at the last step, their ends continued as they were when the steps set out."""
        lines = self.model.centrelines(self._x)
        return ", ".join(knot_type(points, ends).name for points, ends in zip(lines, self._ends, strict=True))

    def _take(self, step: Step, motion: Motion, *, anew: bool) -> Iterator[Passed]:
        model, account, watch = self.model, self.account, KnotWatch(self.model)
        progress, origin = Progress.at(motion), motion.x.copy()
        equations = model.equations(step, motion.time, origin, {}, progress)
        equations.system.update(motion.x)
        account.open(motion.x, motion.v, anew=anew)
        rest = AtRest(step, model, motion.time) if isinstance(step, Relax | Release) else None
        try:
            for accepted in march_of(model, step, equations.system, progress, motion.time):
                x = accepted.motion.x
                if model.scene.contact.enabled:
                    watch.check_passage(accepted.start.motion.x, x, accepted.motion.time)
                balance = account.book(equations, accepted.start, x, accepted.motion.v, origin)
                self._note(step, accepted, balance)
                yield Passed(step, accepted, balance, account.energies.missing)
                if rest is not None and rest.reached(accepted.motion.time, account.energies, balance):
                    break
        finally:
            equations.system.close()

    def _note(self, step: Step, accepted: Accepted, balance: Balance) -> None:
        self._x = accepted.motion.x
        self.jacobian = min([self.jacobian, *(rod.bulk.smallest_j for rod in self.model.body.rods)])
        self.penetration = max(self.penetration, balance.penetration)
        self.cutbacks += accepted.failed
        self.steps += 1
        if not isinstance(step, Relax):
            e = self.account.energies
            self.missing = max(self.missing, abs(e.missing))
            self.turned_over = max(self.turned_over, abs(e.work), e.elastic, e.friction, e.drag)


def force_curve(passed: list[Passed]) -> tuple[np.ndarray, np.ndarray]:
    """Displacements [mm] and forces [N] at the stops of the last step."""
    last = [p for p in passed if p.step is passed[-1].step and p.accepted.arrived]
    return np.array([p.balance.displacement for p in last]), np.array([p.balance.force for p in last])
