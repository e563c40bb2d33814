"""Marching of rods in time: the solid's (`knotfem.solver.march`), which no strand may use to leap over another."""

from __future__ import annotations

import numpy as np

from knotfem.solver.effect import StepStart, longest_move
from knotfem.solver.march import March
from knotfem.solver.newton import Iterations, StepFailed

MOST_MOVE = 1.5
"""A step that moves a node further than this many times what is aimed at is taken again, shorter: a thin strand whipped
across another in one step would come out on its far side."""


class RodMarch(March):
    """Marching of rods in time: the solid's, with a bound on the move of a step."""

    def _attempt(self, start: StepStart) -> tuple[np.ndarray, Iterations]:
        x, took = super()._attempt(start)
        moved = longest_move(x - self.progress.motion.x)
        if moved > MOST_MOVE * self.control.move and start.dt > self.control.smallest:
            raise StepFailed(f"a node moved by {moved:.3g} mm in one step")
        return x, took
