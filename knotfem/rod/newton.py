"""Newton's method for rods: that of the solid (`knotfem.solver.newton`) on four unknowns a node.

The first iteration of a step carries prescribed unknowns to their targets and the rest along with them; a
Levenberg-Marquardt shift is raised where a step is too long or the merit does not fall, lowered where steps are taken
whole; in the endgame there is no line search, friction being no potential.
"""

from __future__ import annotations

import numpy as np

from knotfem.rod.system import RodSystem
from knotfem.solver.effect import StepStart
from knotfem.solver.linear import SingularMatrixError
from knotfem.solver.march import March
from knotfem.solver.newton import Iterations, NewtonSettings, StepFailed
from knotfem.solver.sparsity import Matrix


def out_of_balance(residual: np.ndarray, fixed: np.ndarray) -> tuple[float, float]:
    """Largest free residual, and largest running sum of forces from the first node on [N]; shapes [nodes, 4]."""
    free = np.where(fixed, 0.0, residual)
    sums = np.cumsum(free[:, :3], axis=0)
    return float(np.abs(free).max()), float(np.sqrt(np.einsum("ni,ni->n", sums, sums).max()))


def solve(
    system: RodSystem, x: np.ndarray, start: StepStart, settings: NewtonSettings, shift: float = 0.0
) -> tuple[np.ndarray, Iterations]:
    """Find the state in balance at the end of a step.

    Args:
        system: begun with `start`.
        x: predicted state, shape [nodes, 4]; prescribed unknowns may still be off their targets.
        start: the step.
        settings: tolerances and limits.
        shift: Levenberg-Marquardt shift to begin with [N/mm].

    Returns:
        State, shape [nodes, 4], and what it took.

    Raises:
        StepFailed: not converged, or a singular matrix.
    """
    took = Iterations(shift=shift)
    targets = system.targets(start.end)
    while True:
        system.update(x)
        residual, matrix = system.tangent(x)
        gap = np.where(system.fixed, targets - x, 0.0)
        lifted = bool(np.abs(gap).max() > 0.0)
        took.residual, took.resultant = out_of_balance(residual, system.fixed)
        if not np.isfinite(took.residual):
            raise StepFailed("the residual is not finite")
        balanced = took.residual < settings.force_tolerance and took.resultant < settings.resultant_tolerance
        if balanced and not lifted and took.count > 0:
            return x, took
        if took.count >= settings.max_iterations:
            raise StepFailed(f"no balance after {took.count} iterations: residual {took.residual:.2e} N")
        du = _direction(system, matrix, residual, gap, lifted, settings, took)
        took.count += 1
        system.increment(du)
        fraction = _fraction(system, x, du, residual, lifted, settings, took)
        x = x + fraction * du
        if lifted:
            x = np.where(system.fixed, targets, x)
        system.advance(fraction)


def _raised(shift: float, settings: NewtonSettings) -> float:
    return min(max(4.0 * shift, settings.shift_start), settings.shift_cap)


def _direction(
    system: RodSystem, matrix: Matrix, residual: np.ndarray, gap: np.ndarray, lifted: bool, settings: NewtonSettings,
    took: Iterations,
) -> np.ndarray:  # fmt: skip
    rhs = -residual
    if lifted:
        rhs = rhs - matrix.multiply(gap.ravel()).reshape(gap.shape)
    values = matrix.data.copy()
    while True:
        try:
            du = system.solve(matrix, took.shift, rhs)
        except SingularMatrixError as error:
            if took.shift >= settings.shift_cap:
                raise StepFailed(str(error)) from error
            du = None
        if du is not None:
            move = float(np.abs(du).max())
            if lifted or move <= settings.largest_move:
                return du + gap
            if took.shift >= settings.shift_cap:
                return du * (settings.largest_move / move)
        took.shift = _raised(took.shift, settings)
        matrix.data[:] = values


def _fraction(
    system: RodSystem, x: np.ndarray, du: np.ndarray, residual: np.ndarray, lifted: bool, settings: NewtonSettings,
    took: Iterations,
) -> float:  # fmt: skip
    """Armijo line search on the merit; the shift follows how it went."""
    move = float(np.abs(du).max())
    if lifted or move < settings.endgame_move:
        took.shift = 0.0 if took.shift < settings.shift_start else 0.25 * took.shift
        return 1.0
    slope = float(np.sum(np.where(system.fixed, 0.0, residual) * du))
    before = system.merit(x)
    fraction = 1.0
    for _ in range(6):
        after = system.merit(x + fraction * du)
        if after <= before + 1e-4 * fraction * min(slope, 0.0) + 1e-10 * abs(before):
            break
        curvature = after - before - fraction * slope
        best = -slope * fraction**2 / (2.0 * curvature) if np.isfinite(curvature) and curvature > 0.0 else 0.0
        fraction = min(max(best, 0.1 * fraction), 0.5 * fraction)
    if fraction < 1.0:
        took.shift = _raised(took.shift, settings)
    else:
        took.shift = 0.0 if took.shift < settings.shift_start else 0.5 * took.shift
    return fraction


MOST_MOVE = 1.5
"""A step that moves a node further than this many times what is aimed at is taken again, shorter: a thin strand whipped
across another in one step would come out on its far side."""


class RodMarch(March):
    """Marching of rods in time: the solid's step control with the rods' Newton's method."""

    def _attempt(self, start: StepStart) -> tuple[np.ndarray, Iterations]:
        assert isinstance(self.system, RodSystem)
        p, x = self.progress, self.progress.motion.x
        self.system.update(x)
        self.system.begin(start)
        if p.increment_dt > 0.0:
            move = p.increment * (start.dt / p.increment_dt)
            x = x + min(effect.admissible(x, move) for effect in self.system.effects) * move
        x, took = solve(self.system, x, start, self.settings, p.shift)
        moved = float(np.abs(x - p.motion.x).max())
        if moved > MOST_MOVE * self.control.move and start.dt > self.control.smallest:
            raise StepFailed(f"a node moved by {moved:.3g} mm in one step")
        return x, took
