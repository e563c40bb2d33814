"""Inertia and viscous drag, both on the lumped mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.solver.term import Moving
from knotfem.sparse.pattern import Matrix


@dataclass
class Inertia(Moving):
    """m ((1 - alpha_m) a + alpha_m a_n) of a time integration scheme.

    The weight of the static residual is not the effect's: the system applies `scheme.alpha_f`.

    Args:
        mass: [tonne], shape [nodes], or of each unknown, shape [nodes, width].
    """

    mass: np.ndarray

    def __post_init__(self) -> None:
        self.name = "inertia"

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        s, start = self.scheme, self.start
        a = (1.0 - s.alpha_m) * s.acceleration(x, start) + s.alpha_m * start.motion.a
        residual += _each(self.mass, x) * a
        if matrix is not None:
            rate = (1.0 - s.alpha_m) * s.acceleration_rate(start.dt)
            matrix.add_diagonal((rate * _each(self.mass, x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        s, start = self.scheme, self.start
        rate = (1.0 - s.alpha_m) * s.acceleration_rate(start.dt)
        if rate == 0.0:
            return 0.0
        a = (1.0 - s.alpha_m) * s.acceleration(x, start) + s.alpha_m * start.motion.a
        return 0.5 / rate * float(np.einsum("ni,ni->", _each(self.mass, x), a * a))


@dataclass
class Drag(Moving):
    """Viscous drag c m v on the mass.

    Args:
        mass: [tonne], shape [nodes], or of each unknown, shape [nodes, width].
        rate: c [1/s].
    """

    mass: np.ndarray
    rate: float

    def __post_init__(self) -> None:
        self.name = "drag"
        self.viscous = True

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual += self.rate * _each(self.mass, x) * self.scheme.velocity(x, self.start)
        if matrix is not None:
            slope = self.rate * self.scheme.velocity_rate(self.start.dt)
            matrix.add_diagonal((slope * _each(self.mass, x)).ravel())
        return True

    def merit(self, x: np.ndarray) -> float:
        v = self.scheme.velocity(x, self.start)
        slope = self.scheme.velocity_rate(self.start.dt)
        return 0.5 * self.rate / slope * float(np.einsum("ni,ni->", _each(self.mass, x), v * v))


def _each(mass: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Mass of each unknown, shape of x."""
    return np.broadcast_to(mass if mass.ndim == 2 else mass[:, None], x.shape)
