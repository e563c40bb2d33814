"""Inertia and viscous drag, both on the lumped mass."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.solver.effect import Effect, StepStart
from knotfem.solver.schemes import Scheme
from knotfem.solver.sparsity import Matrix


@dataclass
class Inertia(Effect):
    """m ((1 - alpha_m) a + alpha_m a_n) of a time integration scheme.

    The weight of the static residual is not the effect's: the system applies `scheme.alpha_f`.

    Args:
        mass: [tonne], shape [nodes], or of each unknown, shape [nodes, width].
        scheme: of the system.
    """

    mass: np.ndarray
    scheme: Scheme
    _start: StepStart | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.name = "inertia"

    def integrate(self, scheme: Scheme) -> None:
        self.scheme = scheme

    def begin(self, start: StepStart) -> None:
        self._start = start

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        assert self._start is not None, "begin before assemble"
        s, start = self.scheme, self._start
        a = (1.0 - s.alpha_m) * s.acceleration(x, start) + s.alpha_m * start.motion.a
        residual += _each(self.mass, x) * a
        if matrix is not None:
            rate = (1.0 - s.alpha_m) * s.acceleration_rate(start.dt)
            matrix.add_diagonal((rate * _each(self.mass, x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        assert self._start is not None, "begin before merit"
        s, start = self.scheme, self._start
        rate = (1.0 - s.alpha_m) * s.acceleration_rate(start.dt)
        if rate == 0.0:
            return 0.0
        a = (1.0 - s.alpha_m) * s.acceleration(x, start) + s.alpha_m * start.motion.a
        return 0.5 / rate * float(np.einsum("ni,ni->", _each(self.mass, x), a * a))


@dataclass
class Drag(Effect):
    """Viscous drag c m v on the mass.

    Args:
        mass: [tonne], shape [nodes], or of each unknown, shape [nodes, width].
        rate: c [1/s].
        scheme: of the system.
    """

    mass: np.ndarray
    rate: float
    scheme: Scheme
    _start: StepStart | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.name = "drag"
        self.viscous = True

    def integrate(self, scheme: Scheme) -> None:
        self.scheme = scheme

    def begin(self, start: StepStart) -> None:
        self._start = start

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        assert self._start is not None, "begin before assemble"
        residual += self.rate * _each(self.mass, x) * self.scheme.velocity(x, self._start)
        if matrix is not None:
            slope = self.rate * self.scheme.velocity_rate(self._start.dt)
            matrix.add_diagonal((slope * _each(self.mass, x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        assert self._start is not None, "begin before merit"
        v = self.scheme.velocity(x, self._start)
        slope = self.scheme.velocity_rate(self._start.dt)
        return 0.5 * self.rate / slope * float(np.einsum("ni,ni->", _each(self.mass, x), v * v))


def _each(mass: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Mass of each unknown, shape of x."""
    return np.broadcast_to(mass if mass.ndim == 2 else mass[:, None], x.shape)
