"""What every term of the equations is to the solver: a residual, a tangent, and history variables.

A term holds what never changes (connectivity, stiffness) and work space. What it must remember from one accepted state
to the next is a value, its history variables: `load` takes them from a state, `history` gives them to the next one.
A step that is rejected is dropped; the next attempt loads the state that it set out from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from knotfem.solver.constraints import Clamp
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion
from knotfem.sparse.pattern import Matrix, Pattern
from knotfem.types import Arrays, History


class Role(Enum):
    """What a term is in the balances of forces and energy."""

    ELASTIC = "elastic"
    """Resists deformation of the rods and stores energy."""
    CONTACT = "contact"
    """Keeps surfaces apart; stores the energy of the penalty."""
    FRICTION = "friction"
    """Resists sliding; takes work."""
    FIELD = "field"
    """A conservative force from outside, such as weight; stores energy."""
    LOAD = "load"
    """A force from outside that puts work in."""
    RESISTANCE = "resistance"
    """Viscous: takes work, nothing at rest."""
    NUMERICAL = "numerical"
    """Stands in for all viscous terms and inertia where there is no real time: takes work, nothing in equilibrium."""
    INERTIA = "inertia"
    """Mass times acceleration."""
    KINEMATICS = "kinematics"
    """Exerts no force; others build on its history variables."""


VISCOUS = Role.RESISTANCE, Role.NUMERICAL
"""Roles of terms that take work at the rate at which something moves."""
RATES = *VISCOUS, Role.INERTIA
"""Roles of terms that carry nothing in equilibrium."""


@dataclass(frozen=True, eq=False)
class Conditions:
    """What a step of a scene prescribes besides constraints and loads.

    Attributes:
        friction: multiplies all coefficients between rods, as a function of time [s]; None for 1.
        drag: rate of the drag on the mass in real time [1/s]; None for the term's own.
        clamps: ends of discrete rods whose orientation is given.
        real: whether it goes in real time; otherwise there is no velocity.
        frictionless: whether nothing rubs, whatever the coefficients; friction then begins anew.
    """

    friction: History | None = None
    drag: float | None = None
    clamps: Sequence[Clamp] = ()
    real: bool = True
    frictionless: bool = False


@dataclass(frozen=True, eq=False)
class TimeStep:
    """A step: where it begins, how long it is, how it is integrated, and under which conditions.

    Attributes:
        start: accepted motion.
        dt: time over which rates are taken [s]; 0 asks for the forces of the accepted motion itself.
        scheme: time integration.
        conditions: of the scene's step.
        advance: of loads, schedules and prescribed motions [s]; None for `dt`, which is real time.
    """

    start: Motion
    dt: float
    scheme: Scheme = field(default_factory=Scheme)
    conditions: Conditions = field(default_factory=Conditions)
    advance: float | None = None

    @property
    def end(self) -> float:
        """Time at its end [s]."""
        return self.start.time + (self.dt if self.advance is None else self.advance)

    def velocity(self, x: np.ndarray) -> np.ndarray:
        """Velocity [mm/s] at the end of the step that ends at x, shape [nodes, width]."""
        return self.scheme.velocity(x, self.start, self.dt)

    @property
    def velocity_rate(self) -> float:
        """Derivative of the velocity with respect to the position [1/s]."""
        return self.scheme.velocity_rate(self.dt)


class Term:
    """Base of all terms: one that does nothing.

    The residual is internal minus external force [N], shape [nodes, width]; the tangent is its derivative with respect
    to the unknowns. Terms with unknowns of their own condense them: `increment` finds their change from a step in the
    nodal unknowns, `advance` takes a fraction of it.

    Attributes:
        name: of its kind, for tables and figures of cost; terms of one name are told apart by `number`.
        role: in the balances of forces and energy.
        external: whether its force comes from outside the rods.
        symmetric: whether the tangent is symmetric.
        number: of what it belongs to, from 1 on, where terms of its name may be absent from others; 0 for none.
    """

    name: str = ""
    role: Role = Role.LOAD
    external: bool = False
    symmetric: bool = True
    number: int = 0

    @property
    def admissible(self) -> bool:
        """Whether the state last assembled can be one of equilibrium: no element is inverted."""
        return True

    def describe(self) -> str:
        """Its main figures with units, for a reader."""
        return "on"

    def couplings(self, nodes: int) -> np.ndarray | None:
        """Adjacency keys (see `Pattern.from_keys`) that the tangent needs; None when the diagonal is enough."""
        return None

    def allocate(self, pattern: Pattern) -> None:
        """A new pattern is in force."""

    def begin(self, step: TimeStep) -> None:
        """A time step begins."""

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        """Fraction of a predicted move `dx` from x, shape [nodes, width], that the term lets through."""
        return 1.0

    def update(self, x: np.ndarray) -> None:
        """Positions have changed by much or little."""

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        """Add to the residual and, where given, to the matrix. Returns False where the pattern must be built anew."""
        return True

    def increment(self, du: np.ndarray) -> None:
        """Find the change of the term's own unknowns that belongs to a full step `du`, shape [nodes, width]."""

    def advance(self, fraction: float) -> None:
        """Take a fraction of that change."""

    def merit(self, x: np.ndarray) -> float:
        """Contribution to the line search's merit, with the full increment of the term's own unknowns."""
        return 0.0

    def commit(self, x: np.ndarray) -> None:
        """The step to x is accepted: bring the history variables up to date."""

    def energy(self, x: np.ndarray) -> float:
        """Stored energy [N mm]."""
        return 0.0

    def dissipation(self) -> float | None:
        """Work taken in the last accepted step [N mm] where the term knows it; None to take it from its forces."""
        return None

    def slip(self) -> float:
        """Longest slip of a contact in the last accepted step, beyond the stick distance [mm]."""
        return 0.0

    def history(self) -> Arrays:
        """Copies of its history variables."""
        return {}

    def load(self, history: Arrays) -> None:
        """Take history variables; empty ones are those with which the term begins."""
