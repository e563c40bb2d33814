"""Large bending of slender rods against beam theory and against solids computed elsewhere."""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.scene.stiffness import bending_stiffness, mass_per_length
from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Term, TimeStep
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.gravity import Gravity
from knotfem.terms.load import EndForce, FollowingForce
from knotfem.verify.benchmarks.rods import (
    WHOLE_STEPS,
    Rod,
    accepted_steps,
    at_rest,
    beam_clamp,
    bent_into_arc,
    cross_sections,
    final_state,
    make_rod,
    static,
)
from knotfem.verify.case import Case, Quantity

X_AXIS = np.array([1.0, 0.0, 0.0])


class GrowingWeight(Gravity):
    """Gravity that grows from 0 to its full value in one second."""

    def __init__(self, mass: np.ndarray, acceleration: np.ndarray) -> None:
        super().__init__(mass, acceleration)
        self.full = acceleration

    def begin(self, step: TimeStep) -> None:
        self.acceleration = self.full * step.end


def loaded(rod: Rod, loads: list[Term]) -> np.ndarray:
    """Centreline of a cantilever under loads that grow within one second, shape [sections, 3]."""
    x = rod.mesh.nodes
    system = System([*rod.terms, *loads], Unknowns(len(x)), make_solver("auto"), Scheme(), beam_clamp(rod))
    steps = accepted_steps(
        system, at_rest(x), cross_sections(rod), [1.0], first=0.25, largest=0.25, move=1e3, newton=WHOLE_STEPS
    )
    return final_state(steps).x[rod.axis]


def elastica(
    load: float, slope: float, shortening: float, sag: float, element: str, slices: int, section: int
) -> list[Quantity]:
    """Dead transverse tip load a = P L^2 / EI on a cantilever of L / r = 120."""
    rod = make_rod(120.0, slices, radius=1.0, section=section, element=element)
    force = load * rod.bending / 120.0**2
    end = EndForce(rod.sections[-1], rod.end_weights, lambda t: force * t * X_AXIS)
    reaction = EndForce(rod.sections[0], rod.end_weights, lambda t: -force * t * X_AXIS)
    line = loaded(rod, [end, reaction])
    t = line[-1] - line[-2]
    return [
        Quantity("tip slope", float(np.arctan2(t[0], t[2])), slope, 0.01),
        Quantity("shortening / L", float(1.0 - line[-1, 2] / 120.0), shortening, 0.01),
        Quantity("sag / L", float(line[-1, 0] / 120.0), sag, 0.01),
    ]


def sagging(rod: Rod, g: float) -> float:
    """Sag [mm] of the tip under the rod's own weight."""
    weight = g * rod.mass.sum()
    reaction = EndForce(rod.sections[0], rod.end_weights, lambda t: -weight * t * X_AXIS)
    return float(loaded(rod, [GrowingWeight(rod.mass, g * X_AXIS), reaction])[-1, 0])


def heavy_cantilever(gamma: float, sag: float) -> list[Quantity]:
    """Own weight, Gamma = rho A g L^3 / B."""
    rod = make_rod(120.0, 40, radius=1.5)
    g = gamma * rod.bending / (mass_per_length(rod.density, 1.5) * 120.0**3)
    return [Quantity("sag / L", sagging(rod, g) / 120.0, sag, 0.01)]


def paper_rod(length: float, sag: float) -> list[Quantity]:
    """The paper's rod (B = 89.4 N mm^2) held at one end."""
    rod = make_rod(length, 40, youngs=89.4 / bending_stiffness(1.0, 3.0))
    return [Quantity("sag [mm]", sagging(rod, 9810.0), sag, 0.01)]


def roll_up() -> list[Quantity]:
    """An end moment 2 pi B / L bends the rod into a closed circle."""
    rod = make_rod(120.0, 40, radius=1.0, section=20)
    moment = 2.0 * np.pi * rod.bending / 120.0
    couple = FollowingForce(
        rod.sections[-1], -rod.couple_weights(0), int(rod.axis[-2]), int(rod.axis[-1]), lambda t: moment * t
    )
    x = bent_into_arc(rod, 1.8 * np.pi)
    system = System([*rod.terms, couple], Unknowns(len(x)), make_solver("auto"), Scheme(), beam_clamp(rod))
    steps = accepted_steps(system, at_rest(x, 0.9), cross_sections(rod), [1.0], first=0.025, newton=WHOLE_STEPS)
    line = final_state(steps).x[rod.axis]
    return [
        Quantity("end gap / L", float(np.linalg.norm(line[-1] - line[0])) / 120.0, 0.005, kind="at most"),
        Quantity("diameter / (L / pi)", float(np.ptp(line[:, 0])) * np.pi / 120.0, 1.0, 0.005),
    ]


def pure_bending(section: int, match_bending: bool, element: str, expected: float) -> list[Quantity]:
    """One end face clamped, the other carried as a rigid plate along a quarter of a circle."""
    rod = make_rod(60.0, 60, section=section, element=element, poisson=0.49, match_bending=match_bending)
    angle, X = 0.5 * np.pi, rod.mesh.nodes
    near, far = rod.sections[0], rod.sections[-1]
    radius = 60.0 / angle
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    centre = np.array([radius, 0.0, radius])
    plate = centre + (X[far] - [0.0, 0.0, 60.0]) @ turn.T
    ends = [held(near, X[near]), Prescribed(far, lambda time: plate)]
    x, system, _ = static(rod.terms, bent_into_arc(rod, angle), ends, cross_sections(rod), tolerance=1e-7)
    force = system.residual(x)[far]
    moment = float(np.cross(x[far] - centre, force).sum(axis=0)[1])
    return [Quantity("M [N mm]", moment, expected, 0.01)]


_ELASTICA = {1.0: (0.46135, 0.05643, 0.30172), 5.0: (1.21537, 0.38763, 0.71379)}
_DEAD_LOAD = "Bisshopp and Drucker 1945"

CASES = [
    *(
        Case(
            "elastica",
            partial(elastica, load, *values, element, slices, section),
            f"dead tip load, P L^2 / EI = {load:g}",
            _DEAD_LOAD,
            f"{element}, {slices} x {section}, L / r = 120",
            f"{element}-{load:g}",
            slow=element == "hex8" and load > 1.0,
        )
        for element, slices, section in (("hex8-reduced", 40, 20), ("hex8", 400, 12))
        for load, values in _ELASTICA.items()
    ),
    *(
        Case(
            "heavy-cantilever",
            partial(heavy_cantilever, gamma, sag),
            f"own weight, rho A g L^3 / B = {gamma:g}",
            "shooting",
            "hex8-reduced, 40 x 12, L / r = 80",
            f"{gamma:g}",
        )
        for gamma, sag in ((1.0, 0.12347), (5.0, 0.49591), (10.0, 0.70020))
    ),
    *(
        Case(
            "paper-rod",
            partial(paper_rod, length, sag),
            f"the paper's rod sags, {length:g} mm",
            "shooting, B = 89.4 N mm^2",
            "hex8-reduced, 40 x 12, d = 6",
            f"{length:g}mm",
        )
        for length, sag in ((80.0, 17.83), (120.0, 68.12))
    ),
    Case("roll-up", roll_up, "end moment 2 pi B / L", "Simo and Vu-Quoc 1986", "hex8-reduced, 40 x 20, L / r = 120"),
    Case(
        "pure-bending",
        partial(pure_bending, 44, False, "hex8", 2.031),
        "a right angle, the paper's mesh",
        "two other programs on this mesh",
        "hex8, 60 x 44 on the circle, no core",
        "paper-mesh",
    ),
    Case(
        "pure-bending",
        partial(pure_bending, 104, True, "hex8-reduced", 2.11),
        "a right angle, the true circle",
        "two other programs, refined",
        "hex8-reduced, 60 x 104, stiffness matched",
        "true-circle",
        slow=True,
    ),
]
