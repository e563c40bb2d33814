"""The equations of rods: a `System` of four unknowns a node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.mesh.rod_layout import RodLayout
from knotfem.solver.constraints import Prescribed
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Term
from knotfem.sparse.linear import LinearSolver
from knotfem.sparse.rod_pattern import RodPattern


class RodSystem(System):
    """The solid's system with four unknowns a node, some of them frozen.

    Args:
        effects: in the order in which they are assembled.
        layout: of the rods.
        solver: linear solver.
        scheme: time integration scheme.
        prescribed: nodes whose places are given, positions of shape [n, 3].
        frozen: unknowns that keep their value besides, boolean, shape [nodes, 4].
    """

    width = 4

    def __init__(
        self,
        effects: Sequence[Term],
        layout: RodLayout,
        solver: LinearSolver,
        scheme: Scheme,
        prescribed: Sequence[Prescribed] = (),
        frozen: np.ndarray | None = None,
    ) -> None:
        super().__init__(effects, layout.nodes, solver, scheme, prescribed)
        self.symmetric = False
        self._driven = self.fixed.copy()
        self.frozen = np.zeros((self.nodes, 4), dtype=bool) if frozen is None else frozen.copy()
        self.frozen[layout.last, 3] = True
        self.fixed[self.frozen] = True
        self._kept = np.zeros((self.nodes, 4))

    def keep(self, x: np.ndarray) -> None:
        """Frozen unknowns keep the values that they have in x, shape [nodes, 4]."""
        self._kept = np.where(self.frozen, x, 0.0)

    def targets(self, time: float) -> np.ndarray:
        """Values of the prescribed unknowns at a time, shape [nodes, 4]; zero where nothing is prescribed."""
        return np.where(self._driven, super().targets(time), self._kept)

    def _pattern(self, keys: np.ndarray) -> RodPattern:
        return RodPattern.from_keys(keys, self.nodes, False)
