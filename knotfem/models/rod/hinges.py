"""What bending and twisting share: a stiffness at every hinge."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from knotfem.models.rod.frames import Frames
from knotfem.solver.term import Term
from knotfem.sparse.rod_pattern import stencil_keys


@dataclass
class Hinged(Term, ABC):
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

    def couplings(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.frames.stencils, nodes)

    @abstractmethod
    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        """Couple of each clamp on its rod [N mm], shape [clamps, 3]."""

    @property
    def _clamped(self) -> slice:
        """The hinges of clamps, which are the last."""
        return slice(len(self.frames.hinges) - len(self.frames.clamps), None)

    def _clamps(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions left and right of the clamps' hinges, and whether the clamp is on the left, shape [clamps, 3]."""
        hinges = self.frames.hinges[self._clamped]
        tangent = self.frames.current(x)[0]
        left = (hinges[:, 0] >= self.frames.layout.nodes)[:, None]
        return tangent[hinges[:, 0]], tangent[hinges[:, 1]], left

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)
