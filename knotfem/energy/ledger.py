"""The energy account of rods, step by step."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field

import numpy as np

from knotfem.models.rod.frames import Frames
from knotfem.models.rod.hinges import Hinged
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.terms.registry import INTERNAL_DAMPING

ELASTIC = ("stretch", "bend", "twist")
CONTACT = ("contact", "cylinder")
RUBBING = ("friction", "cylinder friction")


@dataclass
class Energies:
    """Energies [N mm].

    Stored, each the present value: stretch, bend, twist, contact, springs (of sticking friction), gravity, kinetic.
    Summed since the account was opened: work of supports, clamps and loads; what friction, drag of any kind, internal
    damping and the time integration took.
    """

    stretch: float = 0.0
    bend: float = 0.0
    twist: float = 0.0
    contact: float = 0.0
    springs: float = 0.0
    gravity: float = 0.0
    kinetic: float = 0.0
    work: float = 0.0
    friction: float = 0.0
    drag: float = 0.0
    damping: float = 0.0
    numerical: float = 0.0

    @property
    def elastic(self) -> float:
        return self.stretch + self.bend + self.twist

    @property
    def stored(self) -> float:
        return self.elastic + self.contact + self.springs + self.gravity + self.kinetic


@dataclass
class Ledger:
    """Keeps the account of a system's steps.

    Works are taken by the trapezoidal rule: of supports, clamps and loads; of friction, less what its springs keep; of
    drag. `numerical` is the rest that closes the account: what an implicit step damps, plus the error of that rule.

    Args:
        mass: that goes with each unknown [tonne], shape [nodes, 4]; None for rods without inertia.

    Attributes:
        energies: as of the last booked step.
        friction_step, damping_step, numerical_step: what the last step took.
        drag_by: what each resistance from outside took in it, by name.
    """

    mass: np.ndarray | None
    energies: Energies = field(default_factory=Energies)
    friction_step: float = 0.0
    drag_by: dict[str, float] = field(default_factory=dict)
    damping_step: float = 0.0
    numerical_step: float = 0.0
    _before: dict[str, np.ndarray] = field(default_factory=dict, init=False)
    _couples: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)), init=False)

    @property
    def drag_step(self) -> float:
        """What all resistances from outside took in the last step."""
        return sum(self.drag_by.values())

    def open(self, system: System, frames: Frames, x: np.ndarray, v: np.ndarray, time: float) -> None:
        """A phase is about to march from x, shape [nodes, 4]; sums go on.

        What the hinge of a clamp stored that is let go is lost: the time integration takes it.
        """
        stored, begun = self.energies.stored, bool(self._before)
        self._store(system, x, v)
        if begun:
            self.energies.numerical += stored - self.energies.stored
        self._before = {}
        here = StepStart(Motion(x, v, np.zeros_like(v), time), 0.0)
        for effect in system.effects:
            effect.begin(here)
            if not effect.viscous and effect.name != "inertia":
                effect.assemble(x, self._before.setdefault(effect.name, np.zeros_like(x)), None)
        self._couples = clamp_couples(system, frames, x)

    def book(self, system: System, frames: Frames, start: StepStart, x: np.ndarray, v: np.ndarray) -> None:
        """Book an accepted step that ended at x with velocity v, shapes [nodes, 4]."""
        e = self.energies
        stored = e.stored
        forces, couples = system.forces(x), clamp_couples(system, frames, x)
        dx, nothing, before_couples = x - start.motion.x, np.zeros_like(x), self._couples
        before = {**forces, **self._before}

        def trapezoidal(name: str) -> float:
            return 0.5 * float(np.sum((before[name] + forces[name]) * dx)) if name in forces else 0.0

        both = sum(before.values(), nothing) + sum(forces.values(), nothing)
        work = 0.5 * float(np.sum(np.where(system.fixed, both, 0.0) * dx)) - trapezoidal("load")
        for c, clamp in enumerate(frames.clamps):
            turn = rotation_between(clamp.orientation(start.motion.time), clamp.orientation(start.end))
            work += 0.5 * float((before_couples[c] + couples[c]) @ turn)
        springs = e.springs
        resisting = dict.fromkeys(e.name for e in system.effects if e.viscous and e.name != INTERNAL_DAMPING)
        self.drag_by = {name: trapezoidal(name) for name in resisting}
        self.damping_step = sum(effect.dissipated for effect in _named(system, INTERNAL_DAMPING))
        self._store(system, x, v)
        self.friction_step = sum(trapezoidal(name) for name in RUBBING) - (e.springs - springs)
        taken = self.friction_step + self.drag_step + self.damping_step
        self.numerical_step = work - (e.stored - stored) - taken
        e.work += work
        e.friction += self.friction_step
        e.drag += self.drag_step
        e.damping += self.damping_step
        e.numerical += self.numerical_step
        self._before, self._couples = forces, couples

    @property
    def forces(self) -> dict[str, np.ndarray]:
        """Residual of each effect as of the last booked step, by name, shape [nodes, 4]."""
        return self._before

    def state(self) -> dict:
        """For a checkpoint."""
        return {"energies": asdict(self.energies), "before": self._before, "couples": self._couples}

    def restore(self, state: dict) -> None:
        """From a checkpoint."""
        self.energies = Energies(**state["energies"])
        self._before, self._couples = state["before"], state["couples"]

    def _store(self, system: System, x: np.ndarray, v: np.ndarray) -> None:
        e = self.energies
        for name in ELASTIC:
            setattr(e, name, sum(effect.energy(x) for effect in _named(system, name)))
        e.contact = sum(effect.energy(x) for name in CONTACT for effect in _named(system, name))
        e.springs = sum(effect.kept for name in RUBBING for effect in _named(system, name))
        e.gravity = sum(effect.energy(x) for effect in _named(system, "gravity"))
        e.kinetic = 0.0 if self.mass is None else 0.5 * float(np.sum(self.mass * v * v))


def _named(system: System, name: str) -> list:
    return system.effect(name)


def clamp_couples(system: System, frames: Frames, x: np.ndarray) -> np.ndarray:
    """Couple of each clamp on its rod [N mm], shape [clamps, 3]."""
    none = np.zeros((len(frames.clamps), 3))
    return sum((effect.clamp_couples(x) for effect in system.effects if isinstance(effect, Hinged)), none)


def rotation_between(before: tuple[np.ndarray, np.ndarray], after: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Rotation vector [rad], shape [3], from one tangent and director to another."""
    from scipy.spatial.transform import Rotation

    def matrix(frame: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        return np.stack([frame[0], frame[1], np.cross(frame[0], frame[1])], axis=1)

    return Rotation.from_matrix(matrix(after) @ matrix(before).T).as_rotvec()
