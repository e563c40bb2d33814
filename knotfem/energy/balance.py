"""What each accepted step is held against: balance of forces, balance of energy, penetration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from knotfem.energy.energies import Energies
from knotfem.geometry.finite_rotation import rotation_vector
from knotfem.models.base import Equations, Model
from knotfem.solver.state import State
from knotfem.solver.stepping.integrator import AcceptedStep
from knotfem.solver.system import System
from knotfem.solver.term import RATES, VISCOUS, Role, Term, TimeStep

Forces = Mapping[str, np.ndarray]
"""Residual of each term by its label, shape [nodes, width]."""


@dataclass(frozen=True)
class StepFigures:
    """Figures of one accepted step.

    Attributes:
        force: along the reported drive, at its end [N].
        displacement: of that end since the start of the scene's step [mm].
        contacts: samples that carry force.
        sliding: those of them that slide.
        penetration: deepest [mm].
        imbalance: size of the sum of all external forces, drag and inertia not counted [N].
        drag_force: size of the sum of all viscous forces [N].
        dynamic_residual: largest sum of viscous and inertia forces from the start of a rod up to any of its sections,
            which static balance lacks [N].
        reactions: force on each end that is held, driven or loaded, by label [N].
    """

    force: float
    displacement: float
    contacts: int
    sliding: int
    penetration: float
    imbalance: float
    drag_force: float
    dynamic_residual: float
    reactions: dict[str, list[float]] = field(default_factory=dict)


class EnergyBalance:
    """Keeps the energy balance of a run and measures each step.

    Works are taken by the trapezoidal rule: of supports, clamps and loads; of friction; of drag.
    What the time integration takes is the work on inertia beyond the gain in kinetic energy.

    Args:
        model: of the scene.

    Attributes:
        energies: so far.
        end_forces: force on each end that is held, driven or loaded, by label [N], shape [3].
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.energies = Energies()
        self.end_forces: dict[str, list[float]] = {}
        self._forces: dict[str, np.ndarray] = {}
        self._couples = np.zeros((0, 3))

    def begin(self, equations: Equations, state: State, *, anew: bool) -> None:
        """A step of the scene sets out from a state; with `anew` the balance starts there.

        What is stored in the vertex of a clamp that is let go is lost: the time integration takes it.
        """
        system, before = equations.system, self.energies.stored
        here = TimeStep(state, 0.0, system.scheme, system.conditions)
        system.load(state)
        system.update(state.x)
        self._forces = {}
        for label, term in system.labels.items():
            term.begin(here)
            if term.role not in RATES:
                self._forces[label] = np.zeros_like(state.x)
                term.assemble(state.x, self._forces[label], None)
        self._couples = self.model.clamp_couples(state.x)
        if anew:
            stored = _stored(Energies(), system, state)
            self.energies = replace(stored, initial=stored.stored)
        else:
            stored = _stored(self.energies, system, state)
            self.energies = replace(stored, algorithmic=stored.algorithmic + before - stored.stored)

    def update(self, equations: Equations, accepted: AcceptedStep, origin: State) -> StepFigures:
        """Take an accepted step into the balance.

        Args:
            equations: of the scene's step.
            accepted: the time step.
            origin: state at the start of the scene's step.
        """
        system, state = equations.system, accepted.state
        forces, couples = system.forces(state.x), self.model.clamp_couples(state.x)
        self.energies = self._updated(system, accepted, forces, couples)
        self._forces, self._couples = forces, couples
        return self._figures(equations, forces, state.x, origin.x)

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        return {
            "energies": asdict(self.energies),
            "forces": self._forces,
            "couples": self._couples,
            "end_forces": self.end_forces,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self.energies = Energies(**state["energies"])
        self._forces, self._couples, self.end_forces = state["forces"], state["couples"], state["end_forces"]

    def _updated(self, system: System, accepted: AcceptedStep, forces: Forces, couples: np.ndarray) -> Energies:
        e, before = self.energies, {**forces, **self._forces}
        dx = accepted.state.x - accepted.start.x

        def work(label: str) -> float:
            return 0.5 * float(np.sum((before[label] + forces[label]) * dx))

        both = _sum(before, dx) + _sum(forces, dx)
        done = 0.5 * float(np.sum(np.where(system.fixed, both, 0.0) * dx))
        done += self._clamp_work(system, accepted, couples)
        done -= sum(work(label) for label in _labels(system, Role.LOAD))
        sliding = sum(work(label) for label in _labels(system, Role.FRICTION))
        after = _stored(e, system, accepted.state)
        return replace(
            after,
            work=e.work + done,
            throughput=e.throughput + abs(done),
            friction=e.friction + sliding,
            taken=_taken(e, system, work),
            algorithmic=e.algorithmic + inertial_work(system, before, forces, dx) - (after.kinetic - e.kinetic),
        )

    def _clamp_work(self, system: System, accepted: AcceptedStep, couples: np.ndarray) -> float:
        work = 0.0
        for c, clamp in enumerate(system.conditions.clamps):
            frames = [_frame(*clamp.orientation(time)) for time in (accepted.start.time, accepted.state.time)]
            work += 0.5 * float((self._couples[c] + couples[c]) @ rotation_vector(*frames))
        return work

    def _figures(self, equations: Equations, forces: Forces, x: np.ndarray, origin: np.ndarray) -> StepFigures:
        system, total = equations.system, _sum(forces, x)
        reactions = {label: _resultant(total[nodes]) for label, nodes in equations.supports.items()}
        imbalance = _imbalance(system, forces, reactions)
        loads = _sum_of((Role.LOAD,), system, forces, x)
        for label, nodes, _ in equations.drives:
            reactions.setdefault(label, -_resultant(loads[nodes]))
        self.end_forces = {label: value.tolist() for label, value in reactions.items()}
        force = displacement = 0.0
        if equations.drives:
            label, nodes, direction = equations.drives[0]
            displacement = float((x[nodes, :3] - origin[nodes, :3]).mean(axis=0) @ direction)
            force = float(reactions[label] @ direction)
        contacts = system.having(Role.CONTACT)
        viscous = _sum_of(VISCOUS, system, forces, x)
        dynamic = viscous + _sum_of((Role.INERTIA,), system, forces, x)
        return StepFigures(
            force,
            displacement,
            sum(_figure(c, "touching") for c in contacts),
            sum(_figure(f, "sliding") for f in system.having(Role.FRICTION)),
            max((_figure(c, "penetration") for c in contacts), default=0.0),
            imbalance,
            float(np.linalg.norm(_resultant(viscous))),
            self.model.sections.largest_sum(dynamic),
            dict(self.end_forces),
        )


def inertial_work(system: System, before: Forces, after: Forces, dx: np.ndarray) -> float:
    """Work on inertia in a step [N mm]; what exceeds the gain in kinetic energy the time integration takes.

    The scheme balances inertia against forces that it weighs otherwise than the trapezoidal rule of all works:
    backward Euler those at the end of the step. The work of the difference counts here, also at an end let go.

    Args:
        system: of the step.
        before: residual of each term at the start of the step, by label.
        after: the same at its end.
        dx: move of the step, shape [nodes, width].
    """
    start, end = (_sum_of((Role.INERTIA,), system, forces, dx) for forces in (before, after))
    others = _sum(after, dx) - end - (_sum(before, dx) - start)
    balancing = np.where(system.fixed, 0.5 * (start + end), end + (0.5 - system.scheme.alpha_f) * others)
    return float(np.sum(balancing * dx))


def _stored(e: Energies, system: System, state: State) -> Energies:
    """The energies with what is stored in a state."""
    x = state.x
    fields: dict[str, float] = {}
    for term in system.having(Role.FIELD):
        fields[term.name] = fields.get(term.name, 0.0) + term.energy(x)
    moving = system.having(Role.INERTIA)
    return replace(
        e,
        elastic=sum(term.energy(x) for term in system.having(Role.ELASTIC)),
        contact=sum(term.energy(x) for term in system.having(Role.CONTACT)),
        fields=fields,
        kinetic=sum(kinetic(state.v) for term in moving if (kinetic := getattr(term, "kinetic_energy", None))),
    )


def _taken(e: Energies, system: System, work: Callable[[str], float]) -> dict[str, float]:
    taken = dict(e.taken)
    for label in _labels(system, *VISCOUS):
        term = system.labels[label]
        known = term.dissipation()
        taken[term.name] = taken.get(term.name, 0.0) + (work(label) if known is None else known)
    return taken


def _figure(term: Term, name: str) -> Any:
    """A figure that terms of its role have; 0 of a term of the user's own without it."""
    return getattr(term, name, 0)


def _imbalance(system: System, forces: Forces, reactions: Mapping[str, np.ndarray]) -> float:
    """Size of the sum of all external forces [N], resistances and inertia not counted."""
    external = sum(reactions.values(), np.zeros(3))
    for label, term in system.labels.items():
        if term.external and term.role not in RATES:
            external = external - _resultant(forces[label])
    return float(np.linalg.norm(external))


def _labels(system: System, *roles: Role) -> list[str]:
    return [label for label, term in system.labels.items() if term.role in roles]


def _sum_of(roles: tuple[Role, ...], system: System, forces: Forces, like: np.ndarray) -> np.ndarray:
    """Sum of the residuals of all terms of some roles, shape [nodes, width]."""
    return _sum({label: forces[label] for label in _labels(system, *roles)}, like)


def _sum(forces: Forces, like: np.ndarray) -> np.ndarray:
    return sum(forces.values(), np.zeros_like(like))


def _resultant(forces: np.ndarray) -> np.ndarray:
    """Sum of the forces on nodes, shape [3]; what else a node may carry is left out."""
    return forces[:, :3].sum(axis=0)


def _frame(tangent: np.ndarray, director: np.ndarray) -> np.ndarray:
    return np.stack([tangent, director, np.cross(tangent, director)])
