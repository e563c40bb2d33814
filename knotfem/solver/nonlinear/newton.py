"""Newton's method with the globalisation that contact of slender rods needs.

Each safeguard and its reason: docs/solver.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from knotfem.errors import NotConverged
from knotfem.solver.system import System
from knotfem.solver.term import StepStart, longest_move
from knotfem.sparse.linear import SingularMatrixError


class StepFailed(NotConverged):
    """A time step did not converge; it can be tried again with a shorter one."""


@dataclass(frozen=True)
class NewtonSettings:
    """Tolerances and limits; lengths in mm, forces in N.

    Attributes:
        force_tolerance: largest out-of-balance force of one unknown.
        resultant_tolerance: largest out-of-balance force summed over all nodes up to any cross-section.
        max_iterations: a step that needs more has failed.
        largest_move: longest move of a node in one iteration, beyond twice what the prescribed ones still lack.
        endgame_move: below it steps are taken whole, with no line search.
        shift_start: first Levenberg-Marquardt shift of the whole rod [N/mm].
        shift_cap: largest one.
        chord_safety: an iteration takes the last factorisation again where so many times the residual that it promises
            is within tolerance; infinite for a factorisation each.
    """

    force_tolerance: float = 1e-5
    resultant_tolerance: float = 1e-4
    max_iterations: int = 30
    largest_move: float = 1.5
    endgame_move: float = 0.03
    shift_start: float = 0.01
    shift_cap: float = 100.0
    chord_safety: float = 10.0


@dataclass
class Iterations:
    """What a solve took, and the shift to begin the next with."""

    count: int = 0
    shift: float = 0.0
    residual: float = np.inf
    resultant: float = np.inf


def out_of_balance(residual: np.ndarray, fixed: np.ndarray, sections: np.ndarray) -> tuple[float, float]:
    """Largest free residual, and largest running sum of section sums of forces along each rod [N].

    Args:
        residual: shape [nodes, width].
        fixed: prescribed unknowns, shape [nodes, width].
        sections: index of the cross-section of each node, ascending, shape [nodes].
    """
    free = np.where(fixed, 0.0, residual)
    sums = np.stack([np.bincount(sections, weights=free[:, i]) for i in range(3)], axis=1)
    return float(np.abs(free).max()), float(np.linalg.norm(np.cumsum(sums, axis=0), axis=1).max())


def solve(
    system: System,
    x: np.ndarray,
    start: StepStart,
    settings: NewtonSettings,
    sections: np.ndarray,
    shift: float = 0.0,
    interrupt: Callable[[], None] | None = None,
) -> tuple[np.ndarray, Iterations]:
    """Find the positions in balance at the end of a step.

    Args:
        system: begun with `start`.
        x: predicted positions, shape [nodes, width]; prescribed unknowns may still be off their targets.
        start: the step.
        settings: tolerances and limits.
        sections: see `out_of_balance`.
        shift: Levenberg-Marquardt shift to begin with [N/mm].
        interrupt: called before each iteration; it ends the solve by raising.

    Returns:
        Positions, shape [nodes, width], and what it took.

    Raises:
        StepFailed: not converged, inverted elements, or a singular matrix.
    """
    took = Iterations(shift=shift)
    targets = system.targets(start.end)
    x = x.copy()
    excess, moved, whole, chord = np.inf, np.inf, False, False
    while True:
        system.update(x)
        residual, matrix = (system.residual(x), None) if chord else system.tangent(x)
        gap = np.where(system.fixed, targets - x, 0.0)
        lifted = bool(np.abs(gap).max() > 0.0)
        took.residual, took.resultant = out_of_balance(residual, system.fixed, sections)
        if not np.isfinite(took.residual):
            raise StepFailed("the residual is not finite")
        before = excess
        excess = max(took.residual / settings.force_tolerance, took.resultant / settings.resultant_tolerance)
        if not lifted and took.count > 0 and excess < 1.0:
            if not system.admissible:
                raise StepFailed("an element is inverted")
            return x, took
        if took.count >= settings.max_iterations:
            raise StepFailed(f"no balance after {took.count} iterations: residual {took.residual:.2e} N")
        if interrupt is not None:
            interrupt()
        promising = whole and not chord and settings.chord_safety * excess * excess < before
        du = system.resolve(-residual) if promising and not lifted else None
        chord = du is not None and longest_move(du) < moved
        if du is None or not chord:
            if matrix is None:
                residual, matrix = system.tangent(x)
            du = _direction(system, matrix, residual, gap, lifted, settings, took)
        took.count += 1
        system.increment(du)
        fraction = _fraction(system, x, du, residual, lifted, settings, took)
        moved, whole = longest_move(du), fraction == 1.0 and not lifted
        x = x + fraction * du
        if lifted:
            x = np.where(system.fixed, targets, x)
        system.advance(fraction)


def _direction(system, matrix, residual, gap, lifted, settings, took) -> np.ndarray:
    rhs = -residual
    if lifted:
        rhs = rhs - matrix.multiply(gap.ravel()).reshape(gap.shape)
    values = matrix.data.copy()
    limit = settings.largest_move + 2.0 * longest_move(gap)
    while True:
        try:
            du = system.solve(matrix, took.shift, rhs)
        except SingularMatrixError as error:
            if took.shift >= settings.shift_cap:
                raise StepFailed(str(error)) from error
            du = None
        if du is not None:
            move = longest_move(du)
            if move <= limit:
                return du + gap
            if took.shift >= settings.shift_cap:
                return du * (limit / move) + gap
        took.shift = min(max(4.0 * took.shift, settings.shift_start), settings.shift_cap)
        matrix.data[:] = values


def _fraction(system, x, du, residual, lifted, settings, took) -> float:
    """Armijo line search on the merit; the shift follows how it went."""
    move = longest_move(du)
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
        took.shift = min(max(4.0 * took.shift, settings.shift_start), settings.shift_cap)
    else:
        took.shift = 0.0 if took.shift < settings.shift_start else 0.5 * took.shift
    return fraction
