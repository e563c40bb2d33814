"""What every effect is to the solver: a residual, a tangent, and what it must remember."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from knotfem.sparse.pattern import Matrix, Pattern

if TYPE_CHECKING:
    from knotfem.solver.schemes import Scheme

Arrays = dict[str, np.ndarray]


@dataclass
class Motion:
    """Positions and velocities of all nodes at one time.

    Attributes:
        x: positions [mm], shape [nodes, 3].
        v: velocities [mm/s], shape [nodes, 3].
        a: accelerations [mm/s^2], shape [nodes, 3].
        time: [s].
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    time: float = 0.0

    @classmethod
    def at_rest(cls, x: np.ndarray, time: float = 0.0) -> Motion:
        return cls(x.copy(), np.zeros_like(x), np.zeros_like(x), time)

    def copy(self) -> Motion:
        return Motion(self.x.copy(), self.v.copy(), self.a.copy(), self.time)


def longest_move(dx: np.ndarray) -> float:
    """Length of the longest move of a node, whichever way it points; of what else a node carries the largest change.

    Args:
        dx: shape [nodes, width], the first three along x, y, z.
    """
    move = float(np.sqrt(np.einsum("ni,ni->n", dx[:, :3], dx[:, :3]).max()))
    return max(move, float(np.abs(dx[:, 3:]).max(initial=0.0)))


@dataclass(frozen=True)
class StepStart:
    """The accepted state a time step sets out from, and its length."""

    motion: Motion
    dt: float

    @property
    def end(self) -> float:
        return self.motion.time + self.dt


@dataclass
class Term:
    """Base of all effects: one that does nothing.

    The residual is internal minus external force [N], shape [nodes, 3]; the tangent is its derivative with respect to
    the positions. Effects with unknowns of their own condense them: `increment` finds their change from a step in the
    positions, `advance` takes a fraction of it.

    Attributes:
        symmetric: whether the tangent is symmetric.
        viscous: whether it is a resistance, which takes work and is nothing at rest.
        number: of what it belongs to, from 1 on, where effects of its name may be absent from others; 0 for none.
    """

    name: str = field(default="", init=False)
    symmetric: bool = field(default=True, init=False)
    viscous: bool = field(default=False, init=False)
    number: int = field(default=0, init=False)

    @property
    def admissible(self) -> bool:
        """Whether the state last assembled can be one of equilibrium: no element is inside out."""
        return True

    def couplings(self, nodes: int) -> np.ndarray | None:
        """Adjacency keys (see `Pattern.from_keys`) that the tangent needs; None when the diagonal is enough."""
        return None

    def allocate(self, pattern: Pattern) -> None:
        """A new pattern is in force."""

    def integrate(self, scheme: Scheme) -> None:
        """A system with this scheme has the effect now."""

    def begin(self, start: StepStart) -> None:
        """A time step sets out from an accepted state."""

    def allowed_fraction(self, x: np.ndarray, dx: np.ndarray) -> float:
        """Fraction of a predicted move `dx` from x, shape [nodes, 3], that the effect lets through."""
        return 1.0

    def update(self, x: np.ndarray) -> None:
        """Positions have changed by much or little."""

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        """Add to the residual and, where given, to the matrix. Returns False where the pattern must be built anew."""
        return True

    def increment(self, du: np.ndarray) -> None:
        """Find the change of the effect's own unknowns that belongs to a full step `du`, shape [nodes, 3]."""

    def advance(self, fraction: float) -> None:
        """Take a fraction of that change."""

    def merit(self, x: np.ndarray) -> float:
        """Contribution to the line search's merit, with the full increment of the effect's own unknowns."""
        return 0.0

    def commit(self, x: np.ndarray) -> None:
        """The step has been accepted: commit what is remembered."""

    def energy(self, x: np.ndarray) -> float:
        """Stored energy [N mm]."""
        return 0.0

    def history(self) -> Arrays:
        """Copies of all that must be kept to undo a step or to go on from a checkpoint."""
        return {}

    def load(self, history: Arrays) -> None:
        """Go back to a history."""


@dataclass
class Moving(Term):
    """Base of effects that know velocities.

    Attributes:
        scheme: how velocities and accelerations follow; that of the system that has the effect.
    """

    scheme: Scheme = field(init=False)
    _start: StepStart | None = field(default=None, init=False)

    def integrate(self, scheme: Scheme) -> None:
        self.scheme = scheme

    def begin(self, start: StepStart) -> None:
        self._start = start

    @property
    def start(self) -> StepStart:
        """Where the step sets out."""
        assert self._start is not None, "begin before assemble"
        return self._start
