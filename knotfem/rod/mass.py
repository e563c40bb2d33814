"""Weight, inertia and drag of the rods, on lumped masses of place and spin.

The fourth unknown is the spin times the radius, so that the spinning mass of a segment of mass m is m/2 (a full
circular section: rho J h = m r^2/2).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.rod.layout import RodLayout
from knotfem.solver.effect import Effect, StepStart
from knotfem.solver.schemes import Scheme
from knotfem.solver.sparsity import Matrix


def lumped_mass(layout: RodLayout, mass_per_length: np.ndarray) -> np.ndarray:
    """Mass [tonne] that goes with each unknown, shape [nodes, 4].

    Args:
        layout: of the rods.
        mass_per_length: of each rod [tonne/mm], shape [rods].
    """
    segment = (np.asarray(mass_per_length, dtype=float) * layout.spacing)[layout.rod[layout.edges]]
    mass = np.zeros((layout.nodes, 4))
    mass[layout.edges, :3] += 0.5 * segment[:, None]
    mass[layout.edges + 1, :3] += 0.5 * segment[:, None]
    mass[layout.edges, 3] = 0.5 * segment
    return mass


@dataclass
class Weight(Effect):
    """Gravity: mass as above, acceleration [mm/s^2], shape [3]."""

    mass: np.ndarray
    acceleration: np.ndarray

    def __post_init__(self) -> None:
        self.name = "gravity"

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[:, :3] -= self.mass[:, :3] * self.acceleration
        return True

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)

    def energy(self, x: np.ndarray) -> float:
        return -float(np.sum(self.mass[:, :3] * x[:, :3] * self.acceleration))


@dataclass
class Inertia(Effect):
    """m ((1 - alpha_m) a + alpha_m a_n) of a time integration scheme."""

    mass: np.ndarray
    scheme: Scheme
    _start: StepStart | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.name = "inertia"

    def begin(self, start: StepStart) -> None:
        self._start = start

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual += self.mass * self._acceleration(x)
        if matrix is not None:
            matrix.add_diagonal((self._rate * self.mass).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        return 0.5 / self._rate * float(np.sum(self.mass * self._acceleration(x) ** 2)) if self._rate else 0.0

    @property
    def _rate(self) -> float:
        assert self._start is not None, "begin before assemble"
        return (1.0 - self.scheme.alpha_m) * self.scheme.acceleration_rate(self._start.dt)

    def _acceleration(self, x: np.ndarray) -> np.ndarray:
        assert self._start is not None, "begin before assemble"
        s, start = self.scheme, self._start
        return (1.0 - s.alpha_m) * s.acceleration(x, start) + s.alpha_m * start.motion.a


@dataclass
class Drag(Effect):
    """Viscous drag on place and spin, rate [1/s] times momentum."""

    mass: np.ndarray
    rate: float
    scheme: Scheme
    _start: StepStart | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.name = "drag"

    def begin(self, start: StepStart) -> None:
        self._start = start

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        assert self._start is not None, "begin before assemble"
        residual += self.rate * self.mass * self.scheme.velocity(x, self._start)
        if matrix is not None:
            matrix.add_diagonal((self.rate * self.scheme.velocity_rate(self._start.dt) * self.mass).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        assert self._start is not None, "begin before merit"
        slope = self.scheme.velocity_rate(self._start.dt)
        return 0.5 * self.rate / slope * float(np.sum(self.mass * self.scheme.velocity(x, self._start) ** 2))
