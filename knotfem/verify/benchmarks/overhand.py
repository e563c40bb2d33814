"""The loose open overhand knot of Audoly, Clauvelin and Neukirch (2007), in hexahedra.

F r^2 / B = eps^4 / 2 + mu sigma eps^3 with eps = sqrt(r / R) is the beginning of an expansion in eps; R is taken as the
radius of the loop's mean curvature. Here eps is 0.145. The first term is within a tenth of the whole there; the second,
sigma eps^3 for the sum N of all contact forces, is too small by half (docs/validation.md). What it stems from holds to
all orders and is tested instead: F = F_0 + mu N where all contacts slide.

The reduced model brings the rod near its equilibrium, the hexahedra go on from there.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.contact.curve_contact import hertz_line_stiffness
from knotfem.contact.penalty import Penalty
from knotfem.contact.tube_contact import Contact
from knotfem.contact.tube_friction import Friction
from knotfem.geometry.frames import rotation_minimising_frame
from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.models.rod.ends import pinned
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.spec import ContactSpec, RodSpec
from knotfem.shipped import centreline_path
from knotfem.solver.constraints import Prescribed, driven, held
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import March, Progress, StepControl
from knotfem.solver.system import System
from knotfem.solver.term import Motion, Term
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag
from knotfem.tie.sweep import swept_state
from knotfem.verify.benchmarks.rods import DENSITY, Rod, make_rod, surfaces
from knotfem.verify.verdict import Case, Quantity

RADIUS, YOUNGS = 3.0, 1.425
BENDING = YOUNGS * np.pi * RADIUS**4 / 4.0
CORE = 75500.0 * np.pi * 0.127**2
"""EA of the paper's core [N]."""
X_AXIS = np.array([1.0, 0.0, 0.0])


def near_equilibrium(length: float, slices: int) -> np.ndarray:
    """Centreline of the reduced model's frictionless knot between pinned ends, shape [slices + 1, 3]."""
    points = equal_chords(read_centreline(centreline_path("overhand")), slices, length).points
    axial, mass = CORE + YOUNGS * np.pi * RADIUS**2, DENSITY * np.pi * RADIUS**2
    rod = RodSpec(points, RADIUS, BENDING, BENDING / 1.5, axial, mass)
    contact = ContactSpec(hertz_line_stiffness(YOUNGS, 0.5), 0.0, ramp=RADIUS / 30.0, sample_spacing=RADIUS / 4.0)
    model = RodModel([rod], contact, drag=20.0)
    model.begin({(0, side): pinned(model.end_frame(0, side)) for side in ("start", "end")})
    for _ in model.march(StepControl(0.01, 1e-8, 50.0, RADIUS), model.settings(), [model.time + 200.0]):
        pass
    return np.array(model.centreline()).reshape(-1, 3)


class Knot:
    """A rod of hexahedra in an overhand knot along x, its first end at +x; the axis nodes of the ends are held."""

    def __init__(self, length: float, slices: int, section: int) -> None:
        points = near_equilibrium(length, slices)
        self.rod: Rod = make_rod(length, slices, section=section, youngs=YOUNGS, core_stiffness=CORE)
        x = swept_state(points, rotation_minimising_frame(points), self.rod.points).reshape(-1, 3)
        law = Penalty(8.0 * YOUNGS, RADIUS / 15.0, RADIUS / 30.0)
        self.contact = Contact(*surfaces([self.rod], 0.25 * RADIUS), law)
        self.drag = Drag(self.rod.mass, 20.0)
        self.effects: list[Term] = [*self.rod.effects, self.drag, self.contact]
        self.motion = Motion.at_rest(x)
        self.reaction = 0.0

    def march(self, ends: list[Prescribed], duration: float, first: float) -> None:
        """Go on for a time [s]; the reactions at its end are kept."""
        system = System(self.effects, len(self.motion.x), make_solver("auto"), Scheme(), ends)
        control = StepControl(first=first, smallest=1e-6 * first, largest=duration, move=RADIUS)
        settings = NewtonSettings(force_tolerance=2e-7, resultant_tolerance=2e-6)
        stop = self.motion.time + duration
        walk = March(system, Progress.at(self.motion), control, settings, self.rod.section_index, np.array([stop]))
        for _ in walk:
            pass
        self.motion = walk.progress.motion
        residual = system.residual(self.motion.x)
        near, far = self.rod.axis[[0, -1]]
        self.reaction = 0.5 * float(residual[near, 0] - residual[far, 0])

    def ends(self, away: float = 0.0, duration: float = 1.0) -> list[Prescribed]:
        """Held, or both drawn apart along x by `away` [mm] in all."""
        x, time = self.motion.x, self.motion.time
        if away == 0.0:
            return [held(self.rod.axis[[0, -1]], x[self.rod.axis[[0, -1]]])]
        return [
            driven(nodes, x[nodes], way * X_AXIS, lambda t: 0.5 * away * (t - time) / duration)
            for nodes, way in ((self.rod.axis[[0]], 1.0), (self.rod.axis[[-1]], -1.0))
        ]

    def loop_radius(self) -> float:
        """One over the mean curvature between the contacts [mm]."""
        c = self.contact
        line = self.motion.x[self.rod.axis]
        at = np.sort(c.samples.u[c.pairs[c.force > 0.0, 0]])
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
    knot.march(knot.ends(), 100.0, 0.02)
    radius, force = knot.loop_radius(), knot.reaction
    friction = Friction(knot.contact, np.array([[mu]]))
    knot.effects.append(friction)
    knot.drag.rate = 0.5
    knot.march(knot.ends(6.0, 3.0), 3.0, 0.05)
    slippery = force * (radius / knot.loop_radius()) ** 2
    pressed = float(knot.contact.force.sum())
    mobilised = float(np.linalg.norm(friction.traction, axis=1).sum()) / (mu * pressed)
    eps = f"eps = {np.sqrt(RADIUS / radius):.3f}"
    return [
        Quantity("F r^2 / B over eps^4 / 2", 2.0 * force * radius**2 / BENDING, 1.0, 0.1, condition=f"mu = 0, {eps}"),
        Quantity("(F - F_0) / (mu N)", (knot.reaction - slippery) / (mu * pressed), 1.0, 0.1, condition=f"mu = {mu:g}"),
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
