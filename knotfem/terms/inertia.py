"""Inertia and drag, physical and numerical, all on the lumped mass."""

from __future__ import annotations

import numpy as np

from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix


class Massive(Term):
    """Base of terms on the lumped mass.

    Args:
        mass: [tonne], shape [nodes], or of each unknown, shape [nodes, width].
    """

    def __init__(self, mass: np.ndarray) -> None:
        self.mass = mass
        self._step: TimeStep | None = None

    @property
    def step(self) -> TimeStep:
        """The present time step."""
        assert self._step is not None, "begin before assemble"
        return self._step

    def begin(self, step: TimeStep) -> None:
        self._step = step

    def masses(self, x: np.ndarray) -> np.ndarray:
        """Mass of each unknown [tonne], shape of x."""
        return np.broadcast_to(self.mass if self.mass.ndim == 2 else self.mass[:, None], x.shape)


class Inertia(Massive):
    """m ((1 - alpha_m) a + alpha_m a_n) of a time integration scheme.

    The weight of the static residual is not the term's: the system applies `scheme.alpha_f`.
    """

    name, role = "inertia", Role.INERTIA

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual += self.masses(x) * self._weighted(x)
        if matrix is not None:
            matrix.add_diagonal((self._rate * self.masses(x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        if self._rate == 0.0:
            return 0.0
        a = self._weighted(x)
        return 0.5 / self._rate * float(np.einsum("ni,ni->", self.masses(x), a * a))

    def kinetic_energy(self, v: np.ndarray) -> float:
        """Kinetic energy [N mm] at velocities [mm/s], shape [nodes, width]."""
        return 0.5 * float(np.sum(self.masses(v) * v * v))

    @property
    def _rate(self) -> float:
        s = self.step.scheme
        return (1.0 - s.alpha_m) * s.acceleration_rate(self.step.dt)

    def _weighted(self, x: np.ndarray) -> np.ndarray:
        step, s = self.step, self.step.scheme
        a = s.acceleration(x, step.start, step.dt)
        return (1.0 - s.alpha_m) * a + s.alpha_m * step.start.a


class Drag(Massive):
    """Viscous drag c m v on the mass.

    Args:
        mass: see `Massive`.
        rate: c [1/s], where the conditions of a step give no other.
    """

    name, role = "drag", Role.RESISTANCE

    def __init__(self, mass: np.ndarray, rate: float = 0.0) -> None:
        super().__init__(mass)
        self.rate = rate

    def describe(self) -> str:
        return f"{self.rate:g} 1/s"

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual += self._now * self.masses(x) * self.step.velocity(x)
        if matrix is not None:
            matrix.add_diagonal((self._now * self.step.velocity_rate * self.masses(x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        v = self.step.velocity(x)
        return 0.5 * self._now / self.step.velocity_rate * float(np.einsum("ni,ni->", self.masses(x), v * v))

    @property
    def _now(self) -> float:
        rate = self.step.conditions.drag
        return self.rate if rate is None else rate


class NumericalDrag(Drag):
    """Drag of quasi-static steps, whose rate no condition changes.

    It makes the motion unique where equilibrium is lost: the rods then move as an overdamped body does.

    Args:
        mass: see `Massive`.
        rate: c [1/s].
    """

    name, role = "numerical_drag", Role.NUMERICAL

    def describe(self) -> str:
        return "in quasi-static steps, as little as the balance of forces allows"

    @property
    def _now(self) -> float:
        return self.rate
