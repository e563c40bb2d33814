"""What bending and twisting share: a stiffness at every vertex."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from knotfem.models.rod.frames import Frames
from knotfem.solver.term import Role, Term
from knotfem.sparse.pattern import stencil_keys


class VertexTerm(Term, ABC):
    """Base of terms with an energy at every vertex.

    Args:
        frames: whose vertices they are.
        stiffness: B or C of each rod [N mm^2], shape [rods].
    """

    role = Role.ELASTIC

    def __init__(self, frames: Frames, stiffness: np.ndarray) -> None:
        self.frames, self.stiffness = frames, np.asarray(stiffness, dtype=float)

    @property
    def modulus(self) -> np.ndarray:
        """Stiffness over length of each vertex [N mm], shape [vertices]."""
        return self.stiffness[self.frames.rods] / self.frames.cell

    def couplings(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.frames.view.stencil, nodes)

    @abstractmethod
    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        """Couple of each clamp on its rod [N mm], shape [clamps, 3]."""

    @property
    def clamped(self) -> slice:
        """The vertices of clamps, which are the last."""
        return slice(len(self.frames.view.edges) - self.frames.clamped.size, None)

    def clamp_directions(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions left and right of the clamps' vertices, shape [clamps, 3], and whether they are on the left."""
        edges = self.frames.view.edges[self.clamped]
        tangent = self.frames.current(x)[0]
        left = (edges[:, 0] >= self.frames.layout.nodes)[:, None]
        return tangent[edges[:, 0]], tangent[edges[:, 1]], left

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)


def listed(values: np.ndarray, name: str, unit: str) -> str:
    """Different values of the rods, for a reader."""
    return f"{name} {', '.join(f'{value:.5g}' for value in np.unique(values))} {unit}"
