"""Own weight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.solver.term import Term
from knotfem.sparse.pattern import Matrix


@dataclass
class Gravity(Term):
    """Weight of the lumped mass.

    Args:
        mass: [tonne], shape [nodes].
        acceleration: [mm/s^2], shape [3].
    """

    mass: np.ndarray
    acceleration: np.ndarray

    def __post_init__(self) -> None:
        self.name = "gravity"

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[:, :3] -= self.mass[:, None] * self.acceleration
        return True

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)

    def energy(self, x: np.ndarray) -> float:
        return -float(self.mass @ (x[:, :3] @ self.acceleration))
