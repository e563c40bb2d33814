"""Line search of Newton's method on a merit that knows the terms' own unknowns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Armijo:
    """Backtracking with quadratic interpolation.

    The merit is an augmented Lagrangian with the new pressures and axial forces and moderate moduli; the true ones
    would reject every rotation of a nearly inextensible rod.

    Attributes:
        decrease: fraction of the decrease promised by the slope that a step must achieve; the usual 1e-4.
        attempts: shortened steps that are tried; six reach a thousandth of the full one.
        shortest, longest: bounds of one shortening, so that a bad interpolation neither stalls nor jumps.
        rounding: increase relative to the merit that counts as none, above its rounding error.
        whole_below: longest move [mm] of a step that is always taken whole. Friction has no potential, and near the
            solution the merit rejects good steps: 38 iterations for each mm and 5 failures without this bound, 3 and
            none with it.
        much: a step that would be shortened below this fraction is taken whole every second time. The merit rejects
            long steps along a soft motion, such as the swing of a free tail, from which Newton's method converges:
            with it the first 6 mm of the bowline take 922 factorisations instead of 1191. 0 for never.
    """

    decrease: float = 1e-4
    attempts: int = 6
    shortest: float = 0.1
    longest: float = 0.5
    rounding: float = 1e-10
    whole_below: float = 0.03
    much: float = 0.3

    def fraction(self, merit: Callable[[float], float], slope: float) -> float:
        """Fraction of a step to take.

        Args:
            merit: at a fraction of the step.
            slope: of the merit at the start, along the whole step.
        """
        before = merit(0.0)
        fraction = 1.0
        for _ in range(self.attempts):
            after = merit(fraction)
            if after <= before + self.decrease * fraction * min(slope, 0.0) + self.rounding * abs(before):
                break
            curvature = after - before - fraction * slope
            best = -slope * fraction**2 / (2.0 * curvature) if np.isfinite(curvature) and curvature > 0.0 else 0.0
            fraction = min(max(best, self.shortest * fraction), self.longest * fraction)
        return fraction
