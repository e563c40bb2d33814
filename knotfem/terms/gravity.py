"""Own weight."""

from __future__ import annotations

import numpy as np

from knotfem.solver.term import Role, Term
from knotfem.sparse.pattern import Matrix


class Gravity(Term):
    """Weight of the lumped mass.

    Args:
        mass: [tonne], shape [nodes].
        acceleration: [mm/s^2], shape [3].
    """

    name, role, external = "gravity", Role.FIELD, True

    def __init__(self, mass: np.ndarray, acceleration: np.ndarray) -> None:
        self.mass, self.acceleration = mass, acceleration

    def describe(self) -> str:
        return f"{np.linalg.norm(self.acceleration) / 1000.0:.4g} m/s^2"

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[:, :3] -= self.mass[:, None] * self.acceleration
        return True

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)

    def energy(self, x: np.ndarray) -> float:
        return -float(self.mass @ (x[:, :3] @ self.acceleration))
