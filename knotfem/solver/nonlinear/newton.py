"""Newton's method with the globalisation that contact of slender rods needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from knotfem.errors import NotConverged
from knotfem.solver.nonlinear.damping import LevenbergMarquardt
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.reuse import Chord
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Imbalance, Sections, imbalance
from knotfem.solver.state import longest_move
from knotfem.solver.system import System
from knotfem.solver.term import TimeStep
from knotfem.sparse.base import SingularMatrixError
from knotfem.sparse.pattern import Matrix

Interrupt = Callable[[], None]
"""Called before each iteration; it ends the solve by raising."""


class StepFailed(NotConverged):
    """A time step did not converge; it can be retried with a shorter one."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Where a solve ended.

    Attributes:
        x: unknowns, shape [nodes, width].
        iterations: of Newton's method.
        imbalance: that is left.
        residual: at x, reactions included [N], shape of x.
        damping: Levenberg-Marquardt damping to begin the next solve with [N/mm].
    """

    x: np.ndarray
    iterations: int
    imbalance: Imbalance
    residual: np.ndarray
    damping: float


@dataclass(frozen=True)
class Newton:
    """Newton's method; its parts say what they are for.

    Attributes:
        tolerance: when a state is in balance.
        line_search: on the merit of the system.
        damping: of the tangent.
        reuse: of factorisations.
        max_iterations: a step that needs more has failed.
        largest_move: longest move of a node in one iteration [mm], a quarter of the diameter, beyond twice what
            prescribed nodes still have to go. Beyond it the damping is raised; without this bound an end that is let go
            throws the first iteration off by 40 mm.
    """

    tolerance: ForceTolerance = field(default_factory=ForceTolerance)
    line_search: Armijo = field(default_factory=Armijo)
    damping: LevenbergMarquardt = field(default_factory=LevenbergMarquardt)
    reuse: Chord = field(default_factory=Chord)
    max_iterations: int = 30
    largest_move: float = 1.5

    def patient(self, factor: int) -> Newton:
        """The same with so many times the iterations."""
        return replace(self, max_iterations=factor * self.max_iterations)

    def solve(
        self,
        system: System,
        x: np.ndarray,
        step: TimeStep,
        sections: Sections,
        damping: float = 0.0,
        interrupt: Interrupt | None = None,
    ) -> Solution:
        """Find the unknowns in balance at the end of a step.

        Args:
            system: begun with `step`.
            x: predicted unknowns, shape [nodes, width]; prescribed ones may still be off their targets.
            step: the time step.
            sections: over which resultants are summed.
            damping: to begin with [N/mm].
            interrupt: called before each iteration.

        Raises:
            StepFailed: not converged, inverted elements, or a singular matrix.
        """
        return _Solve(self, system, step, sections, damping, interrupt).run(x)


class _Solve:
    """One solve: what changes from iteration to iteration."""

    def __init__(
        self,
        newton: Newton,
        system: System,
        step: TimeStep,
        sections: Sections,
        damping: float,
        interrupt: Interrupt | None,
    ) -> None:
        self.newton, self.system, self.sections = newton, system, sections
        self.targets = system.targets(step.end)
        self.damping, self.interrupt = damping, interrupt
        self.iterations = 0
        self.imbalance = Imbalance()
        self._excess = self._moved = np.inf
        self._whole = self._reused = False
        self._shortened_much = 0

    def run(self, x: np.ndarray) -> Solution:
        system, newton = self.system, self.newton
        x = x.copy()
        while True:
            system.update(x)
            residual, matrix = (system.residual(x), None) if self._reused else system.tangent(x)
            prescribed = np.where(system.fixed, self.targets - x, 0.0)
            pending = bool(np.abs(prescribed).max() > 0.0)
            before = self._excess
            self._excess = self._measure(residual)
            if not pending and self.iterations > 0 and self._excess < 1.0:
                if not system.admissible:
                    raise StepFailed("an element is inverted")
                return Solution(x, self.iterations, self.imbalance, residual, self.damping)
            self._check_limits()
            promising = self._whole and not self._reused and newton.reuse.promising(before, self._excess)
            du = system.resolve(-residual) if promising and not pending else None
            self._reused = du is not None and longest_move(du) < self._moved
            if du is None or not self._reused:
                if matrix is None:
                    residual, matrix = system.tangent(x)
                du = self._direction(matrix, residual, prescribed, pending)
            self.iterations += 1
            system.increment(du)
            fraction = self._fraction(x, du, residual, pending)
            self._moved, self._whole = longest_move(du), fraction == 1.0 and not pending
            x = x + fraction * du
            if pending:
                x = np.where(system.fixed, self.targets, x)
            system.advance(fraction)

    def _measure(self, residual: np.ndarray) -> float:
        self.imbalance = imbalance(residual, self.system.fixed, self.sections)
        if not np.isfinite(self.imbalance.residual):
            raise StepFailed("the residual is not finite")
        return self.newton.tolerance.excess(self.imbalance)

    def _check_limits(self) -> None:
        if self.iterations >= self.newton.max_iterations:
            raise StepFailed(f"no balance after {self.iterations} iterations: residual {self.imbalance.residual:.2e} N")
        if self.interrupt is not None:
            self.interrupt()

    def _direction(self, matrix: Matrix, residual: np.ndarray, prescribed: np.ndarray, pending: bool) -> np.ndarray:
        """Newton's step, damped until no node moves further than it may, with the move of prescribed unknowns."""
        rule, rhs = self.newton.damping, -residual
        if pending:
            rhs = rhs - matrix.multiply(prescribed.ravel()).reshape(prescribed.shape)
        values = matrix.data.copy()
        limit = self.newton.largest_move + 2.0 * longest_move(prescribed)
        while True:
            du = None
            try:
                du = self.system.solve(matrix, self.damping, rhs)
            except SingularMatrixError as error:
                if rule.exhausted(self.damping):
                    raise StepFailed(str(error)) from error
            if du is not None:
                move = longest_move(du)
                if move <= limit:
                    return du + prescribed
                if rule.exhausted(self.damping):
                    return du * (limit / move) + prescribed
            self.damping = rule.raised(self.damping)
            matrix.data[:] = values

    def _fraction(self, x: np.ndarray, du: np.ndarray, residual: np.ndarray, pending: bool) -> float:
        """Fraction of the step to take; the damping follows how it went."""
        system, rule = self.system, self.newton.damping
        if pending or longest_move(du) < self.newton.line_search.whole_below:
            self.damping = rule.released(self.damping)
            return 1.0
        slope = float(np.sum(np.where(system.fixed, 0.0, residual) * du))
        fraction = self.newton.line_search.fraction(lambda part: system.merit(x + part * du), slope)
        if fraction < self.newton.line_search.much:
            self._shortened_much += 1
            if self._shortened_much % 2 == 0:
                fraction = 1.0
        self.damping = rule.raised(self.damping) if fraction < 1.0 else rule.lowered(self.damping)
        return fraction
