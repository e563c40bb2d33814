"""What the benchmarks of discrete rods share: the bowline as a scene, phases of rods given as numbers, tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.spec import RodSpec
from knotfem.scene.stiffness import axial_stiffness, bending_stiffness, mass_per_length
from knotfem.solver.constraints import Clamp, Prescribed
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import State
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep, Continuation, integrate
from knotfem.solver.term import Conditions, Term

YOUNGS, DENSITY = 1.425, 1.16e-9
"""Of the paper's rubber [MPa], [tonne/mm^3]."""
CORE = 3826.0
"""Axial stiffness of its wire [N]."""


def bowline(segments: int = 300, **changed: Any) -> dict[str, Any]:
    """Overrides that make discrete rods of a shipped scene with 600 mm of rod; `changed` by key, `_` for a dot."""
    keys = {key.replace("__", "."): value for key, value in changed.items()}
    mesh = {"model": "rod", "rods.0.mesh.element_length": f"{600.0 / segments} mm"}
    return {**mesh, "solver.threads": 1, "output.fields": False, **keys}


def rubber(points: np.ndarray, radius: float = 3.0, axial: float | None = None, **changed: Any) -> RodSpec:
    """A rod of the paper's rubber through these nodes [mm], with its wire unless `axial` is given [N]."""
    bending, mass = bending_stiffness(YOUNGS, radius), mass_per_length(DENSITY, radius)
    stiffness = CORE + axial_stiffness(YOUNGS, radius) if axial is None else axial
    return RodSpec(points, radius, bending, bending / 1.5, stiffness, mass, **changed)


class Phase:
    """Discrete rods under constraints and loads.

    Args:
        rods: and their terms.
        state: that they set out from.
        prescribed: nodes whose places are given.
        clamps: ends whose orientation is given.
        loads: forces.
        scheme: time integration, quasi-static unless given.
        drag: rate [1/s], where it is not the rods' own.

    Attributes:
        system: equations.
        sections: over which resultants are summed.
        now: how to go on, with the accepted state.
    """

    def __init__(
        self,
        rods: DiscreteRods,
        state: State,
        prescribed: Sequence[Prescribed] = (),
        clamps: Sequence[Clamp] = (),
        loads: Sequence[Term] = (),
        scheme: Scheme | None = None,
        drag: float | None = None,
    ) -> None:
        conditions = Conditions(drag=drag, clamps=clamps)
        self.system = rods.system(scheme or Scheme(), prescribed, loads=loads, conditions=conditions)
        self.sections = Sections(rods.layout.sections, rods.layout.first[:-1])
        self.now = Continuation.at(rods.clamped(state, clamps))

    @property
    def state(self) -> State:
        """The accepted state."""
        return self.now.state

    def steps(self, controller: StepController, newton: Newton, end: float) -> Iterator[AcceptedStep]:
        """Yield accepted steps up to a time [s]."""
        for accepted in integrate(self.system, self.now, controller, newton, self.sections, np.array([end])):
            self.now = accepted.after
            yield accepted

    def stiffness(self) -> np.ndarray:
        """Dense tangent of the free unknowns in the accepted state."""
        self.system.begin(self.state, 1e-9)
        free = ~self.system.fixed.ravel()
        return self.system.tangent(self.state.x)[1].to_scipy().toarray()[np.ix_(free, free)]


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[float | str]]) -> None:
    """Print rows under a header."""
    print(f"\n{title}")
    cells = [list(header)] + [[c if isinstance(c, str) else f"{c:.4g}" for c in row] for row in rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    for row in cells:
        print("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)), flush=True)
