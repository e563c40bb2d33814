"""What bending and twisting share: a stiffness at every hinge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.rod.frames import Frames
from knotfem.rod.sparsity import stencil_keys
from knotfem.solver.effect import Effect


@dataclass
class Hinged(Effect):
    """Base of effects with an energy at every hinge.

    Args:
        frames: whose hinges they are.
        stiffness: B or C of each rod [N mm^2], shape [rods].
    """

    frames: Frames
    stiffness: np.ndarray

    @property
    def modulus(self) -> np.ndarray:
        """Stiffness over length of each hinge [N mm], shape [hinges]."""
        stencils = self.frames.stencils
        rods = self.frames.layout.rod[np.where(stencils[:, 0] >= 0, stencils[:, 0], stencils[:, 2])]
        return np.asarray(self.stiffness, dtype=float)[rods] / self.frames.cell

    def keys(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.frames.stencils, nodes)

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)
