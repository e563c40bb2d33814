"""The equations of rods: a `System` of four unknowns a node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.rod.layout import RodLayout
from knotfem.rod.sparsity import RodPattern
from knotfem.solver.effect import Effect
from knotfem.solver.linear import LinearSolver
from knotfem.solver.schemes import Scheme
from knotfem.solver.sparsity import Matrix
from knotfem.solver.system import Prescribed, System


class RodSystem(System):
    """Residual and tangent of rods, for the same Newton's method and the same march as the solid's.

    Args:
        effects: in the order in which they are assembled.
        layout: of the rods.
        solver: linear solver.
        scheme: time integration scheme.
        prescribed: nodes whose places are given, positions of shape [n, 3].
        frozen: unknowns that keep their value besides, boolean, shape [nodes, 4].
    """

    def __init__(
        self,
        effects: Sequence[Effect],
        layout: RodLayout,
        solver: LinearSolver,
        scheme: Scheme,
        prescribed: Sequence[Prescribed] = (),
        frozen: np.ndarray | None = None,
    ) -> None:
        super().__init__(effects, layout.nodes, solver, scheme)
        self.layout = layout
        self.symmetric = False
        self.prescribed = list(prescribed)
        self.frozen = np.zeros((self.nodes, 4), dtype=bool) if frozen is None else frozen.copy()
        self.frozen[layout.last, 3] = True
        self.fixed = self.frozen.copy()
        for motion in self.prescribed:
            self.fixed[motion.nodes, :3] = True
        self._kept = np.zeros((self.nodes, 4))

    def keep(self, x: np.ndarray) -> None:
        """Frozen unknowns keep the values that they have in x, shape [nodes, 4]."""
        self._kept = np.where(self.frozen, x, 0.0)

    def targets(self, time: float) -> np.ndarray:
        """Values of the prescribed unknowns at a time, shape [nodes, 4]; zero where nothing is prescribed."""
        goal = self._kept.copy()
        for motion in self.prescribed:
            goal[motion.nodes, :3] = motion.positions(time)
        return goal

    def solve(self, matrix: Matrix, shift: float, rhs: np.ndarray) -> np.ndarray:
        """Solve with zero at prescribed unknowns.

        Args:
            matrix: tangent; it is constrained and shifted in place.
            shift: Levenberg-Marquardt shift [N/mm] of the whole, shared evenly by the nodes.
            rhs: shape [nodes, 4].

        Returns:
            Shape [nodes, 4].
        """
        if shift > 0.0:
            matrix.add_diagonal(np.full(rhs.size, shift / self.nodes))
        self.clock.run("constrain", matrix.constrain, self.fixed.ravel())
        if self._analysed is not matrix.pattern:
            self.clock.run("analysis", self.solver.analyse, matrix.pattern)
            self._analysed = matrix.pattern
            self.analyses += 1
        self.clock.run("factorisation", self.solver.factorise, matrix)
        self.factorisations += 1
        masked = np.where(self.fixed, 0.0, rhs)
        return self.clock.run("solve", self.solver.solve, masked.ravel()).reshape(-1, 4)

    def forces(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Residual of each effect by itself, by name, shape [nodes, 4]; effects of one name are summed."""
        result: dict[str, np.ndarray] = {}
        for effect in self.effects:
            part = result.setdefault(effect.name, np.zeros((self.nodes, 4)))
            effect.assemble(x, part, None)
        return result

    def _fill(self, keys: np.ndarray) -> Matrix:
        self._keys = keys
        pattern = self.clock.run("pattern", RodPattern.from_keys, keys, self.nodes, False)
        for effect in self.effects:
            self.clock.run("pattern", effect.bind, pattern)
        return Matrix(pattern)

    def _static(self, x: np.ndarray, matrix: Matrix | None) -> tuple[np.ndarray, bool]:
        residual, complete = np.zeros((self.nodes, 4)), True
        for effect in self.effects:
            if effect.name != "inertia":
                complete &= self.clock.run(effect.name, effect.assemble, x, residual, matrix)
        return residual, complete
