"""A rod over a rigid cylinder, half a turn: friction of a rod with a thickness, and bending against tension.

The axis of the cylinder, here called the drum, is y; the ends of the rod hang down along -z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import root_scalar

from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.rigid import Cylinder
from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction
from knotfem.geometry.frames import rotation_minimising_frame
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import brick_formulation
from knotfem.models.solid.resultants import Resultants, resultants
from knotfem.scene.stiffness import axial_stiffness, bending_stiffness
from knotfem.solver.constraints import Prescribed, driven, held
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import State
from knotfem.solver.system import System
from knotfem.solver.term import Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.axial import AxialStiffness
from knotfem.terms.inertia import Drag
from knotfem.terms.load import EndForce
from knotfem.theory import capstan_exponent, tension_ratio
from knotfem.tie.sweep import swept_state
from knotfem.verify.benchmarks.rods import (
    Rod,
    accepted_steps,
    at_rest,
    cross_sections,
    final_state,
    make_rod,
    surfaces,
)
from knotfem.verify.case import Case, Quantity

RADIUS, DRUM = 3.0, 10.0
MIDDLE = RADIUS + DRUM
"""Distance of the centreline from the drum's axis."""
CORE = axial_stiffness(75500.0, 0.127)
"""EA of the paper's core [N]."""
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(eq=False)
class Part:
    """Slices of a rod of one natural curvature.

    Attributes:
        sections: nodes of each of their cross-sections.
        bulk: their hexahedra.
        core: their truss.
    """

    sections: np.ndarray
    bulk: Elasticity
    core: AxialStiffness | None

    @property
    def terms(self) -> list[Term]:
        """Bulk and core."""
        return [self.bulk] if self.core is None else [self.bulk, self.core]


@dataclass(eq=False)
class Draped:
    """A rod over the drum, a little above it, and the terms of both.

    Attributes:
        rod: straight.
        x: draped positions [mm].
        band: the part on the drum.
        drum: contact with the drum.
        terms: of the rod and the drum.
    """

    rod: Rod
    x: np.ndarray
    band: Part
    drum: ObstacleContact
    terms: list[Term]

    def end_force(self, end: int, size: float) -> EndForce:
        """A dead force downwards on an end, which rises linearly to `size` [N] within 1 s."""
        rod = self.rod
        stiffness = rod.youngs * rod.area * rod.end_weights
        if rod.core is not None:
            stiffness[rod.mesh.section.axis] += rod.core.view.stiffness[0]
        return EndForce(rod.sections[end], stiffness / stiffness.sum(), lambda time: size * min(time, 1.0) * DOWN)

    def loaded(self, loads: list[Term], prescribed: list[Prescribed], end: float, state: State) -> tuple[State, System]:
        """The state at a time [s] under loads, from an earlier one, and the equations in it."""
        system = System([*self.terms, *loads], Unknowns(len(self.x)), make_solver("auto"), Scheme(), prescribed)
        steps = accepted_steps(system, state, cross_sections(self.rod), [end], first=0.05, largest=1.0, move=3.0)
        return final_state(steps), system

    def angles(self, x: np.ndarray) -> np.ndarray:
        """Polar angle of the axis nodes of the band from the drum's top, shape [sections]."""
        line = x[self.band.sections[:, self.rod.mesh.section.axis]]
        return np.arctan2(line[:, 0], line[:, 2])

    def resultants(self, x: np.ndarray) -> Resultants:
        """Of the band's sections."""
        band = self.band
        return resultants(x, band.sections, self.rod.mesh.section.axis, band.bulk, band.core)


def drape(
    tail: float,
    spacing: float,
    section: int,
    bending: float,
    *,
    core: float = 0.0,
    mu: float = 0.0,
    naturally_curved: bool = False,
    ramp: float = RADIUS / 15.0,
) -> Draped:
    """A rod over the drum with tails of a length [mm].

    Args:
        tail: length of each tail, about [mm].
        spacing: slice length, about [mm].
        section: elements of the section.
        bending: stiffness B [N mm^2].
        core: EA [N].
        mu: coefficient of friction.
        naturally_curved: whether the middle half turn is free of stress on the drum, so that bending plays no part.
        ramp: of the penalty [mm], whose stiffness is the default; half of it is the stick distance.
    """
    half = round(0.5 * np.pi * MIDDLE / spacing)
    straight = round(tail / spacing)
    slices = 2 * (half + straight)
    turn = 0.5 * np.pi / half
    chord = 2.0 * MIDDLE * np.sin(0.5 * turn)
    youngs = bending / bending_stiffness(1.0, RADIUS)
    rod = make_rod(slices * chord, slices, section=section, youngs=youngs, core_stiffness=core)
    angle = turn * np.arange(-half, half + 1)
    arc = (MIDDLE + 0.6 * ramp) * np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    drop = chord * np.arange(straight, 0, -1)[:, None] * DOWN
    points = np.concatenate([arc[0] + drop, arc, (arc[-1] + drop)[::-1]])
    frames = rotation_minimising_frame(points, start=np.array([-1.0, 0.0, 0.0]))
    x = swept_state(points, frames, rod.points, poisson=0.0 if naturally_curved else 0.5).reshape(-1, 3)
    cylinder = Cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), DRUM)
    drum = ObstacleContact(*surfaces([rod], 0.25 * RADIUS), Penalty(8.0 * youngs, ramp), cylinder)
    parts = [_part(rod, 0, slices)]
    if naturally_curved:
        ends = (0, straight, slices - straight, slices)
        parts = [_part(rod, ends[k], ends[k + 1], turn if k == 1 else 0.0) for k in range(3)]
    terms: list[Term] = [term for part in parts for term in part.terms]
    terms += [Drag(rod.mass, 20.0), drum]
    if mu > 0.0:
        terms.append(Friction(drum, TubeObstacleFriction(0.5 * ramp), np.array([mu])))
    return Draped(rod, x, parts[len(parts) // 2], drum, terms)


def _part(rod: Rod, first: int, last: int, turn: float = 0.0) -> Part:
    """Slices from section `first` to section `last`, each naturally curved by an angle about the drum's axis."""
    bulk, core = rod.bulk, rod.core
    form = bulk.formulation
    if turn > 0.0:
        quads = rod.points[rod.mesh.section.quads]
        faces = []
        for angle in (-0.5 * turn, 0.5 * turn):
            out = MIDDLE + quads[..., 0]
            faces.append(np.stack([out * np.cos(angle) - MIDDLE, quads[..., 1], out * np.sin(angle)], axis=-1))
        form = brick_formulation("hex8-reduced", np.concatenate(faces, axis=1))
    part = Elasticity(bulk.elements[first:last], form, bulk.material, bulk.bulk_modulus)
    return Part(rod.sections[first : last + 1], part, None if core is None else _part_of_core(core, first, last))


def _part_of_core(core: AxialStiffness, first: int, last: int) -> AxialStiffness:
    edges, chosen = core.view, slice(first, last)
    merit = core.merit_stiffness[chosen]
    return AxialStiffness("core", edges.nodes[chosen], edges.length[chosen], edges.stiffness[chosen], merit)


def slips(draped: Draped, weight: float, distance: float) -> tuple[float, float]:
    """A weight [N] on one end, the other end pulled down by a distance [mm] at which all of the rod slips.

    Returns:
        d ln T / d phi within 45 degrees of the top, and the ratio of the end forces.
    """
    rod, load = draped.rod, draped.end_force(-1, weight)
    first = rod.sections[0]
    state, _ = draped.loaded([load], [held(first, draped.x[first])], 1.0, at_rest(draped.x))
    pull = driven(first, state.x[first], DOWN, lambda time: distance * (time - 1.0))
    state, system = draped.loaded([load], [pull], 2.0, state)
    x = state.x
    angle, tension = draped.angles(x), draped.resultants(x).tension
    band = np.abs(angle) < 0.25 * np.pi
    rate = -float(np.polyfit(angle[band], np.log(tension[band]), 1)[0])
    return rate, -float(system.residual(x)[first, 2].sum()) / weight


def naturally_curved(mu: float) -> list[Quantity]:
    """The limit T >> B / rho^2 without flattening of the section: a naturally curved rod, lightly loaded."""
    draped = drape(20.0, 1.0, 12, 90.65, core=CORE, mu=mu, naturally_curved=True, ramp=0.05)
    rate, ratio = slips(draped, 0.5, 0.3)
    thickness = RADIUS / MIDDLE
    return [
        Quantity(
            "d ln T / d phi", rate, capstan_exponent(mu, thickness), 0.02, condition="within 45 degrees of the top"
        ),
        Quantity("T2 / T1", ratio, tension_ratio(mu, np.pi, thickness), 0.05),
    ]


def straight(mu: float) -> list[Quantity]:
    """The paper's rod, naturally straight, T1 = 3 N = 5.6 B / rho^2."""
    _, ratio = slips(drape(30.0, 2.0, 12, 90.65, core=CORE, mu=mu), 3.0, 4.0)
    return [Quantity("T2 / T1", ratio, tension_ratio(mu, np.pi, RADIUS / MIDDLE), 0.05)]


def hung(forces: list[float]) -> list[Quantity]:
    """A frictionless rod with a weight on either end: contact at a point becomes contact along a band.

    For a thin rod the band of contact extends over the angles from -beta to beta, with sin beta = 1 - T* / T, and
    carries a point force at either end. The magnitudes of all contact forces then sum to 2 T (cos beta + beta sin
    beta), from which T* follows.
    """
    bending, tail = 89.4, 80.0
    draped = drape(tail, 2.0, 12, bending, ramp=0.05)
    rod, X = draped.rod, draped.x
    middle = rod.mesh.slices // 2
    times = 1.0 + np.arange(len(forces))

    def weight(time: float) -> np.ndarray:
        return np.interp(time, times, forces) * DOWN

    loads: list[Term] = [EndForce(rod.sections[k], rod.end_weights, weight) for k in (0, -1)]
    top, spoke = rod.axis[[middle]], rod.sections[middle][rod.mesh.section.ring[:1]]
    ends = rod.axis[[0, -1]]
    supports = [
        Prescribed(top, lambda time: X[top], components=(True, True, False)),
        Prescribed(spoke, lambda time: X[spoke], components=(False, True, False)),
        Prescribed(ends, lambda time: X[ends], components=(False, True, False)),
    ]
    quantities = []
    state = at_rest(X)
    for time, force in zip(times, forces, strict=True):
        state, _ = draped.loaded(loads, supports, time, state)
        x, pressing = state.x, draped.drum.touch.force
        whole = float(pressing.sum()) / (2.0 * force)
        beta = float(root_scalar(lambda b, w=whole: np.cos(b) + b * np.sin(b) - w, bracket=(0.0, 1.5)).root)
        onset = force * (1.0 - np.sin(beta))
        quantities.append(
            Quantity("T* [N]", onset, bending / (2.0 * MIDDLE**2), 0.1, condition=f"from contact at T = {force:g} N")
        )
        r = draped.resultants(x)
        pressed = np.bincount(np.round(draped.drum.samples.u).astype(int), weights=pressing)
        away = np.flatnonzero(pressed > 0.0)[-1] + 3
        invariant = (r.tension + r.bending_moment**2 / (2.0 * bending))[away:-2] / force
        worst = float(invariant[np.abs(invariant - 1.0).argmax()])
        quantities.append(Quantity("(T + M^2 / 2 B) / T_end off contact, worst", worst, 1.0, 0.1))
    return quantities


_LAW = "mu a Lambda^2 + Lambda = mu (1 - a)"

CASES = [
    Case(
        "capstan",
        partial(naturally_curved, 0.33),
        "half a turn, T >> B / rho^2: a naturally curved rod",
        _LAW,
        "40 x 12 and tails, h = 1, one point along; ramp 0.05, stick 0.025 mm",
        "naturally-curved",
    ),
    Case(
        "capstan",
        partial(straight, 0.33),
        "half a turn, the paper's rod, T1 = 3 N",
        _LAW,
        "hex8-reduced, 50 x 12, h = 2; default penalty",
        "straight",
    ),
    Case(
        "point-to-band",
        partial(hung, [0.5, 0.4]),
        "a frictionless rod over a drum, a weight on either end",
        "B / 2 rho^2",
        "hex8-reduced, 100 x 12, h = 2; ramp 0.05 mm",
    ),
]
