"""What each accepted step is held against: balance of forces, energy account, penetration."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field

import numpy as np

from knotfem.models.base import Simulation
from knotfem.models.solid.assembly import StepSystem
from knotfem.solver.nonlinear.newton import out_of_balance
from knotfem.solver.system import System
from knotfem.solver.term import StepStart
from knotfem.terms.registry import REGISTERED

Forces = dict[str, np.ndarray]
"""Residual of each effect by name."""
EXTERNAL = ("gravity", "cylinder", "cylinder friction", "load", *REGISTERED)
"""Effects whose forces come from outside the rods, besides the supports; the viscous ones are counted apart."""


@dataclass
class Energies:
    """Energy account since the start of the last relaxing or the first loading step [N mm].

    Stored: elastic, contact, gravity, kinetic, each the present value. Summed: work of supports and loads, and what
    friction, drag and the time integration took. Of registered effects by name: what the viscous ones took, and the
    energy stored in the field of the others.
    """

    work: float = 0.0
    friction: float = 0.0
    drag: float = 0.0
    numerical: float = 0.0
    elastic: float = 0.0
    contact: float = 0.0
    gravity: float = 0.0
    kinetic: float = 0.0
    stored_at_start: float = 0.0
    turnover: float = 0.0
    taken_by: dict[str, float] = field(default_factory=dict)
    stored_by: dict[str, float] = field(default_factory=dict)

    @property
    def stored(self) -> float:
        return self.elastic + self.contact + self.gravity + self.kinetic + sum(self.stored_by.values())

    @property
    def of_registered(self) -> dict[str, float]:
        """What each registered effect took or stores."""
        return {**self.taken_by, **self.stored_by}

    @property
    def missing(self) -> float:
        """Work put in that is neither stored nor dissipated."""
        taken = self.friction + self.drag + self.numerical + sum(self.taken_by.values())
        return self.work - (self.stored - self.stored_at_start) - taken


@dataclass(frozen=True)
class Balance:
    """Figures of one accepted step.

    Attributes:
        force: along the reported drive, at its end [N].
        displacement: of that end since the start of the step [mm].
        contacts: samples that carry force.
        sliding: those of them beyond the stick distance.
        penetration: deepest [mm].
        imbalance: size of the sum of all external forces, drag and inertia not counted [N].
        drag_force: size of the sum of all viscous forces [N].
        unrest: largest running sum of viscous forces and inertia over sections: what static balance lacks [N].
        reactions: force on each end that is held, driven or loaded, by label [N].
    """

    force: float
    displacement: float
    contacts: int
    sliding: int
    penetration: float
    imbalance: float
    drag_force: float
    unrest: float
    reactions: dict[str, list[float]] = field(default_factory=dict)


class Account:
    """Keeps the energy account of a run and balances each step."""

    def __init__(self, model: Simulation) -> None:
        self.model = model
        self.registered = [effect for effect in model.effects if effect.name in REGISTERED]
        self._viscous = list(dict.fromkeys(effect.name for effect in model.effects if effect.viscous))
        self.energies = Energies()
        self.end_forces: dict[str, list[float]] = {}
        self._forces: dict[str, np.ndarray] = {}

    def open(self, x: np.ndarray, v: np.ndarray, *, anew: bool) -> None:
        """A step is about to march from x, shape [nodes, 3]; `anew` starts the account there."""
        self._forces = self._static_forces(x)
        if anew:
            self.energies = Energies()
            self._store(x, v)
            self.energies.stored_at_start = self.energies.stored

    def book(self, step: StepSystem, start: StepStart, x: np.ndarray, v: np.ndarray, origin: np.ndarray) -> Balance:
        """Book an accepted step.

        Args:
            step: its system.
            start: where it set out.
            x: positions where it ended [mm], shape [nodes, 3].
            v: velocities there [mm/s], shape [nodes, 3].
            origin: positions at the start of the scene's step, shape [nodes, 3].
        """
        forces = self._book(step, start, x, v)
        return self._balance(step, forces, sum(forces.values(), np.zeros_like(x)), x, origin)

    def _book(self, step: StepSystem, start: StepStart, x: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Book works, all by the trapezoidal rule, and energies; returns the residual of each effect.

        Loads and resistances have no value where a scene's step begins: that after a first step is taken.
        """
        system, e = step.system, self.energies
        forces = system.forces(x)
        before = {**forces, **self._forces}
        dx = x - start.motion.x
        fixed = system.fixed

        def work(name: str) -> float:
            return float(0.5 * np.sum((before[name] + forces[name]) * dx)) if name in forces else 0.0

        nothing = np.zeros_like(x)
        total_before, total = sum(before.values(), nothing), sum(forces.values(), nothing)
        supports = float(0.5 * np.sum(np.where(fixed, total_before + total, 0.0) * dx))
        kinetic = e.kinetic
        e.work += supports - work("load")
        e.turnover += abs(supports - work("load"))
        e.friction += work("friction") + work("cylinder friction")
        e.drag += work("drag")
        for effect in self.registered:
            if effect.viscous:
                e.taken_by[effect.name] = e.taken_by.get(effect.name, 0.0) + work(effect.name)
        self._store(x, v)
        e.numerical += self._inertial_work(system, before, forces, dx) - (e.kinetic - kinetic)
        self._forces = forces
        return forces

    @staticmethod
    def _inertial_work(system: System, before: Forces, after: Forces, dx: np.ndarray) -> float:
        """Work on inertia in a step [N mm]; what exceeds the gain in kinetic energy the time integration takes.

        The scheme balances inertia against forces that it weighs otherwise than the trapezoidal rule of all works:
        backward Euler those at the end of the step. The work of the difference counts here, also at an end let go.

        Args:
            system: of the step.
            before: residual of each effect at the start of the step, by name.
            after: the same at its end.
            dx: what the step has moved.
        """
        nothing = np.zeros_like(dx)
        start, end = (f.get("inertia", nothing) for f in (before, after))
        others = sum(after.values(), nothing) - end - (sum(before.values(), nothing) - start)
        balancing = np.where(system.fixed, 0.5 * (start + end), end + (0.5 - system.scheme.alpha_f) * others)
        return float(np.sum(balancing * dx))

    def _static_forces(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Residuals that depend on positions alone, by name, shapes [nodes, 3]."""
        forces: dict[str, np.ndarray] = {}
        for effect in self.model.effects:
            if not effect.viscous and effect.name != "inertia":
                effect.assemble(x, forces.setdefault(effect.name, np.zeros_like(x)), None)
        return forces

    def _store(self, x: np.ndarray, v: np.ndarray) -> None:
        e, model = self.energies, self.model
        e.elastic = sum(effect.energy(x) for effect in model.elastic)
        e.contact = sum(effect.energy(x) for name in ("contact", "cylinder") for effect in model.named(name))
        e.gravity = sum(effect.energy(x) for effect in model.named("gravity"))
        e.stored_by = {effect.name: effect.energy(x) for effect in self.registered if not effect.viscous}
        e.kinetic = model.kinetic(v)

    def _balance(self, step: StepSystem, forces, total: np.ndarray, x: np.ndarray, origin: np.ndarray) -> Balance:
        reactions = {label: _resultant(total[nodes]) for label, nodes in step.supports.items()}
        external = sum(reactions.values(), np.zeros(3))
        for name in EXTERNAL:
            if name in forces and name not in self._viscous:
                external = external - _resultant(forces[name])
        on_ends = {**reactions}
        for label, nodes, _ in step.drives:
            if label not in on_ends:
                on_ends[label] = -_resultant(forces["load"][nodes])
        self.end_forces = {label: value.tolist() for label, value in on_ends.items()}
        force = displacement = 0.0
        if step.drives:
            label, nodes, direction = step.drives[0]
            displacement = float((x[nodes, :3] - origin[nodes, :3]).mean(axis=0) @ direction)
            force = float(on_ends[label] @ direction)
        contacts = [c for name in ("contact", "cylinder") for c in self.model.named(name)]
        rubbing = [f for name in ("friction", "cylinder friction") for f in self.model.named(name)]
        return Balance(
            force,
            displacement,
            sum(int(np.count_nonzero(c.force)) for c in contacts),
            sum(f.sliding for f in rubbing),
            max((c.penetration for c in contacts), default=0.0),
            float(np.linalg.norm(external)),
            float(np.linalg.norm(sum((_resultant(forces[name]) for name in self._viscous), np.zeros(3)))),
            self._unrest(forces),
            dict(self.end_forces),
        )

    def _unrest(self, forces: dict[str, np.ndarray]) -> float:
        moving = [forces[name] for name in ("inertia", *self._viscous) if name in forces]
        if not moving:
            return 0.0
        nothing = np.zeros_like(moving[0], dtype=bool)
        return out_of_balance(sum(moving[1:], moving[0]), nothing, self.model.sections)[1]

    def state(self) -> dict:
        """For a checkpoint."""
        return {"energies": asdict(self.energies), "forces": self._forces, "end_forces": self.end_forces}

    def restore(self, state: dict) -> None:
        """From a checkpoint."""
        self.energies = Energies(**state["energies"])
        self._forces, self.end_forces = state["forces"], state["end_forces"]


def _resultant(forces: np.ndarray) -> np.ndarray:
    """Sum of the forces on nodes, shape [3]; what else a node may carry is left out."""
    return forces[:, :3].sum(axis=0)
