"""The loose open overhand knot of Audoly, Clauvelin and Neukirch (2007), in hexahedra.

F r^2 / B = eps^4 / 2 + mu sigma eps^3 with eps = sqrt(r / R) is the beginning of an expansion in eps; R is taken as the
radius of the loop's mean curvature. Here eps is 0.145. The first term is then within a tenth of the force without
friction; the second, sigma eps^3 for the sum N of all contact forces, is too small by half (docs/validation.md). The
relation from which it is derived holds to all orders and is tested instead: F = F_0 + mu N where all contacts slide.

Discrete rods find the neighbourhood of the equilibrium, from which the hexahedra start.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.contact.curve_pairs import hertz_line_stiffness
from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.contact.tube_friction import TubeFriction
from knotfem.geometry.frames import rotation_minimising_frame
from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.spec import ContactSpec, RodSpec
from knotfem.scene.stiffness import axial_stiffness, bending_stiffness, mass_per_length
from knotfem.shipped import centreline_path
from knotfem.solver.constraints import Prescribed, driven, held
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import integrate
from knotfem.solver.system import System
from knotfem.solver.term import Conditions, Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag
from knotfem.tie.sweep import swept_state
from knotfem.verify.benchmarks.rods import (
    DENSITY,
    Rod,
    at_rest,
    cross_sections,
    final_state,
    make_rod,
    surfaces,
)
from knotfem.verify.case import Case, Quantity

RADIUS, YOUNGS = 3.0, 1.425
BENDING = bending_stiffness(YOUNGS, RADIUS)
CORE = axial_stiffness(75500.0, 0.127)
"""EA of the paper's core [N]."""
X_AXIS = np.array([1.0, 0.0, 0.0])


def near_equilibrium(length: float, slices: int) -> np.ndarray:
    """Centreline of a frictionless knot of discrete rods between pinned ends, shape [slices + 1, 3]."""
    points = equal_chords(read_centreline(centreline_path("overhand")), slices, length).points
    axial, mass = CORE + axial_stiffness(YOUNGS, RADIUS), mass_per_length(DENSITY, RADIUS)
    rod = RodSpec(points, RADIUS, BENDING, BENDING / 1.5, axial, mass)
    contact = ContactSpec(
        hertz_line_stiffness(YOUNGS, 0.5), 0.0, ramp=RADIUS / 30.0, stick=RADIUS / 30.0, sample_spacing=RADIUS / 4.0
    )
    rods = DiscreteRods([rod], contact, drag=20.0)
    ends = np.array([0, slices])
    system = rods.system(BackwardEuler(), [held(ends, points[ends])])
    tolerance = ForceTolerance.of(1e-6 * BENDING / RADIUS**2)
    newton = Newton(tolerance, Armijo(whole_below=0.01 * RADIUS), largest_move=0.5 * RADIUS)
    controller = StepController(first=0.01, smallest=1e-8, largest=50.0, move=RADIUS)
    start, sections = Continuation.at(rods.initial), Sections.single(np.arange(slices + 1))
    steps = integrate(system, start, controller, newton, sections, np.array([200.0]))
    return final_state(steps).x[:, :3]


class Knot:
    """A rod of hexahedra in an overhand knot along x, its first end at +x; the axis nodes of the ends are held."""

    def __init__(self, length: float, slices: int, section: int) -> None:
        points = near_equilibrium(length, slices)
        self.rod: Rod = make_rod(length, slices, section=section, youngs=YOUNGS, core_stiffness=CORE)
        x = swept_state(points, rotation_minimising_frame(points), self.rod.points).reshape(-1, 3)
        self.contact = PairContact(*surfaces([self.rod], 0.25 * RADIUS), Penalty(8.0 * YOUNGS, RADIUS / 15.0))
        self.terms: list[Term] = [*self.rod.terms, Drag(self.rod.mass), self.contact]
        self.state = at_rest(x)
        self.reaction = 0.0

    def advance(self, ends: list[Prescribed], duration: float, first: float, drag: float) -> None:
        """Integrate over a time [s] under a drag [1/s]; the reactions at its end are kept."""
        conditions = Conditions(drag=drag)
        nodes = len(self.state.x)
        system = System(self.terms, Unknowns(nodes), make_solver("auto"), Scheme(), ends, conditions=conditions)
        controller = StepController(first=first, smallest=1e-6 * first, largest=duration, move=RADIUS)
        newton = Newton(ForceTolerance(2e-7, 2e-6))
        start, end = Continuation.at(self.state), np.array([self.state.time + duration])
        self.state = final_state(integrate(system, start, controller, newton, cross_sections(self.rod), end))
        residual = system.residual(self.state.x)
        near, far = self.rod.axis[[0, -1]]
        self.reaction = 0.5 * float(residual[near, 0] - residual[far, 0])

    def ends(self, away: float = 0.0, duration: float = 1.0) -> list[Prescribed]:
        """Held, or both drawn apart along x by `away` [mm] in all."""
        x, time = self.state.x, self.state.time
        if away == 0.0:
            return [held(self.rod.axis[[0, -1]], x[self.rod.axis[[0, -1]]])]
        return [
            driven(nodes, x[nodes], way * X_AXIS, lambda t: 0.5 * away * (t - time) / duration)
            for nodes, way in ((self.rod.axis[[0]], 1.0), (self.rod.axis[[-1]], -1.0))
        ]

    def loop_radius(self) -> float:
        """One over the mean curvature between the contacts [mm]."""
        pairs = self.contact.pairs
        line = self.state.x[self.rod.axis]
        at = np.sort(self.contact.samples.u[pairs.sample[pairs.force > 0.0]])
        gap = int(np.argmax(np.diff(at)))
        first, last = int(at[gap]) + 1, int(at[gap + 1]) - 1
        edges = np.diff(line[first : last + 1], axis=0)
        lengths = np.linalg.norm(edges, axis=1)
        t = edges / lengths[:, None]
        turn = np.arccos(np.clip(np.einsum("ni,ni->n", t[1:], t[:-1]), -1.0, 1.0))
        return float(lengths[1:].sum() / turn.sum())


def loose(length: float, slices: int, section: int, mu: float) -> list[Quantity]:
    """At rest without friction, then drawn by 6 mm with friction, so that its contacts slide."""
    knot = Knot(length, slices, section)
    knot.advance(knot.ends(), 100.0, 0.02, drag=20.0)
    radius, force = knot.loop_radius(), knot.reaction
    friction = Friction(knot.contact, TubeFriction(RADIUS / 30.0), np.array([[mu]]))
    knot.terms.append(friction)
    knot.advance(knot.ends(6.0, 3.0), 3.0, 0.05, drag=0.5)
    frictionless = force * (radius / knot.loop_radius()) ** 2
    sliding_force = knot.reaction - frictionless
    pressed = float(knot.contact.pairs.force.sum())
    mobilised = float(np.linalg.norm(friction.view.traction, axis=1).sum()) / (mu * pressed)
    eps = f"eps = {np.sqrt(RADIUS / radius):.3f}"
    return [
        Quantity("F r^2 / B over eps^4 / 2", 2.0 * force * radius**2 / BENDING, 1.0, 0.1, condition=f"mu = 0, {eps}"),
        Quantity("(F - F_0) / (mu N)", sliding_force / (mu * pressed), 1.0, 0.1, condition=f"mu = {mu:g}"),
        Quantity("friction mobilised over mu N", mobilised, 0.95, kind="at least"),
    ]


CASES = [
    Case(
        "overhand",
        partial(loose, 1861.0, 465, 12, 0.1),
        "loose open overhand knot, R / r = 48",
        "Audoly, Clauvelin and Neukirch 2007",
        "hex8-reduced, 465 x 12, h = 4, core; default penalty",
        slow=True,
    )
]
