"""Newton's method in units of the rod."""

from __future__ import annotations

from knotfem.models.base import Model
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance

LARGEST_MOVE_OVER_DIAMETER = 0.25
"""Of an iteration."""
WHOLE_BELOW_OVER_DIAMETER = 0.025
"""Steps of Newton's method that move no node further are taken whole."""


def newton_of(model: Model) -> Newton:
    """As the scene has it."""
    solver, d = model.scene.solver, model.diameter
    return Newton(
        tolerance=ForceTolerance.of(solver.force_tolerance),
        line_search=Armijo(whole_below=WHOLE_BELOW_OVER_DIAMETER * d),
        max_iterations=solver.max_iterations,
        largest_move=LARGEST_MOVE_OVER_DIAMETER * d,
    )
