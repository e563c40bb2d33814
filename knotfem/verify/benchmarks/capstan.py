"""A rod over a rigid cylinder, half a turn: friction with the thickness counted, and bending against tension.

The cylinder's axis is y, the ends hang down along -z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import root_scalar

from knotfem.contact.penalty import Penalty
from knotfem.contact.tube_cylinder import Cylinder, CylinderFriction
from knotfem.geometry.frames import rotation_minimising_frame
from knotfem.models.solid.core import Core
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import brick_formulation
from knotfem.models.solid.resultants import Resultants, resultants
from knotfem.solver.constraints import Prescribed, driven, held
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import March
from knotfem.solver.system import System
from knotfem.solver.term import Motion, Term
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag
from knotfem.terms.load import EndForce
from knotfem.tie.sweep import swept_state
from knotfem.verify.benchmarks.rods import Rod, arrive, make_rod, march, surfaces
from knotfem.verify.verdict import Case, Quantity

RADIUS, DRUM = 3.0, 10.0
MIDDLE = RADIUS + DRUM
"""Distance of the centreline from the drum's axis."""
CORE = 75500.0 * np.pi * 0.127**2
"""EA of the paper's core [N]."""
DOWN = np.array([0.0, 0.0, -1.0])


def thick_capstan(mu: float) -> float:
    """Lambda of T ~ exp(Lambda phi) where a rod slips: mu a Lambda^2 + Lambda = mu (1 - a), a = r / (r + R)."""
    a = RADIUS / MIDDLE
    return float((-1.0 + np.sqrt(1.0 + 4.0 * mu**2 * a * (1.0 - a))) / (2.0 * mu * a))


@dataclass(eq=False)
class Part:
    """Slices of one natural shape.

    Attributes:
        sections: nodes of each of their cross-sections.
        bulk: their hexahedra.
        core: their truss.
    """

    sections: np.ndarray
    bulk: Elasticity
    core: Core | None

    @property
    def effects(self) -> list[Term]:
        return [self.bulk] if self.core is None else [self.bulk, self.core]


@dataclass(eq=False)
class Draped:
    """A rod over the drum, a little above it, and what acts on it.

    Attributes:
        rod: straight.
        x: draped positions [mm].
        band: the part on the drum.
        drum: contact with it.
        effects: of the rod and the drum.
    """

    rod: Rod
    x: np.ndarray
    band: Part
    drum: Cylinder
    effects: list[Term]

    def end_force(self, end: int, size: float) -> EndForce:
        """A weight on an end, full from 1 s on."""
        rod = self.rod
        stiffness = rod.youngs * rod.area * rod.end_weights
        if rod.core is not None:
            stiffness[rod.mesh.section.axis] += rod.core.axial_stiffness
        return EndForce(rod.sections[end], stiffness / stiffness.sum(), lambda time: size * min(time, 1.0) * DOWN)

    def march(self, loads: list[Term], prescribed: list[Prescribed], stop: float, motion: Motion) -> March:
        """Steps under loads, from a motion."""
        system = System([*self.effects, *loads], len(self.x), make_solver("auto"), Scheme(), prescribed)
        settings = NewtonSettings(force_tolerance=1e-5, resultant_tolerance=1e-4)
        sections = self.rod.section_index
        return march(system, motion, sections, [stop], first=0.05, largest=1.0, move=3.0, settings=settings)

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
    moulded: bool = False,
    ramp: float = RADIUS / 15.0,
) -> Draped:
    """A rod over the drum with tails of a length [mm].

    Args:
        tail: length of each tail, about [mm].
        spacing: slice length, about [mm].
        section: elements of the section.
        bending: stiffness B [N mm^2].
        core: EA [N].
        mu: friction.
        moulded: whether the middle half turn is curved by nature, so that bending has no part in what happens.
        ramp: of the penalty, which is otherwise the default; half of it is the stick distance [mm].
    """
    half = round(0.5 * np.pi * MIDDLE / spacing)
    straight = round(tail / spacing)
    slices = 2 * (half + straight)
    turn = 0.5 * np.pi / half
    chord = 2.0 * MIDDLE * np.sin(0.5 * turn)
    youngs = bending / (np.pi * RADIUS**4 / 4.0)
    rod = make_rod(slices * chord, slices, section=section, youngs=youngs, core_stiffness=core)
    angle = turn * np.arange(-half, half + 1)
    arc = (MIDDLE + 0.6 * ramp) * np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    drop = chord * np.arange(straight, 0, -1)[:, None] * DOWN
    points = np.concatenate([arc[0] + drop, arc, (arc[-1] + drop)[::-1]])
    frames = rotation_minimising_frame(points, start=np.array([-1.0, 0.0, 0.0]))
    x = swept_state(points, frames, rod.points, poisson=0.0 if moulded else 0.5).reshape(-1, 3)
    law = Penalty(8.0 * youngs, ramp, 0.5 * ramp)
    drum = Cylinder(surfaces([rod], 0.25 * RADIUS)[1], law, np.zeros(3), np.array([0.0, 1.0, 0.0]), DRUM)
    parts = [_part(rod, 0, slices)]
    if moulded:
        ends = (0, straight, slices - straight, slices)
        parts = [_part(rod, ends[k], ends[k + 1], turn if k == 1 else 0.0) for k in range(3)]
    effects: list[Term] = [effect for part in parts for effect in part.effects]
    effects += [Drag(rod.mass, 20.0), drum]
    if mu > 0.0:
        effects.append(CylinderFriction(drum, np.array([mu])))
    return Draped(rod, x, parts[len(parts) // 2], drum, effects)


def _part(rod: Rod, first: int, last: int, turn: float = 0.0) -> Part:
    """Slices from section `first` to section `last`, each turning by an angle about the drum's axis by nature."""
    bulk, core = rod.bulk, rod.core
    form = bulk.formulation
    if turn > 0.0:
        quads = rod.points[rod.mesh.section.quads]
        faces = []
        for angle in (-0.5 * turn, 0.5 * turn):
            out = MIDDLE + quads[..., 0]
            faces.append(np.stack([out * np.cos(angle) - MIDDLE, quads[..., 1], out * np.sin(angle)], axis=-1))
        form = brick_formulation("hex8-reduced", np.concatenate(faces, axis=1))
    part = Elasticity(bulk.elements[first:last], form, bulk.shear_modulus, bulk.bulk_modulus)
    truss = Core(core.edges[first:last], core.edge_length, core.axial_stiffness) if core is not None else None
    return Part(rod.sections[first : last + 1], part, truss)


def slips(draped: Draped, weight: float, distance: float) -> tuple[float, float]:
    """A weight on one end, the other end pulled down until all of the rod slips.

    Returns:
        d ln T / d phi within 45 degrees of the top, and the ratio of the end forces.
    """
    rod, load = draped.rod, draped.end_force(-1, weight)
    first = rod.sections[0]
    steps = draped.march([load], [held(first, draped.x[first])], 1.0, Motion.at_rest(draped.x))
    arrive(steps)
    motion = steps.progress.motion
    pull = driven(first, motion.x[first], DOWN, lambda time: distance * (time - 1.0))
    steps = draped.march([load], [pull], 2.0, motion)
    x = arrive(steps)
    angle, tension = draped.angles(x), draped.resultants(x).tension
    band = np.abs(angle) < 0.25 * np.pi
    rate = -float(np.polyfit(angle[band], np.log(tension[band]), 1)[0])
    return rate, -float(steps.system.residual(x)[first, 2].sum()) / weight


def moulded(mu: float) -> list[Quantity]:
    """The limit T >> B / rho^2 without flattening of the section: a rod that bends by nature, lightly loaded."""
    draped = drape(20.0, 1.0, 12, 90.65, core=CORE, mu=mu, moulded=True, ramp=0.05)
    rate, ratio = slips(draped, 0.5, 0.3)
    expected = thick_capstan(mu)
    return [
        Quantity("d ln T / d phi", rate, expected, 0.02, condition="within 45 degrees of the top"),
        Quantity("T2 / T1", ratio, float(np.exp(expected * np.pi)), 0.05),
    ]


def straight(mu: float) -> list[Quantity]:
    """The paper's rod, straight by nature, T1 = 3 N = 5.6 B / rho^2."""
    _, ratio = slips(drape(30.0, 2.0, 12, 90.65, core=CORE, mu=mu), 3.0, 4.0)
    return [Quantity("T2 / T1", ratio, float(np.exp(thick_capstan(mu) * np.pi)), 0.05)]


def hung(forces: list[float]) -> list[Quantity]:
    """A frictionless rod with a weight on either end: from touching at a point to lying on.

    In the plane of a thin rod the band reaches from -beta to beta with sin beta = 1 - T* / T and a force at either of
    its ends; all contact forces, each by its size, then sum to 2 T (cos beta + beta sin beta). T* is found from that.
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
    motion = Motion.at_rest(X)
    for time, force in zip(times, forces, strict=True):
        steps = draped.march(loads, supports, time, motion)
        x = arrive(steps)
        motion = steps.progress.motion
        whole = float(draped.drum.force.sum()) / (2.0 * force)
        beta = float(root_scalar(lambda b, w=whole: np.cos(b) + b * np.sin(b) - w, bracket=(0.0, 1.5)).root)
        onset = force * (1.0 - np.sin(beta))
        quantities.append(
            Quantity("T* [N]", onset, bending / (2.0 * MIDDLE**2), 0.1, condition=f"from contact at T = {force:g} N")
        )
        r = draped.resultants(x)
        pressed = np.bincount(np.round(draped.drum.samples.u).astype(int), weights=draped.drum.force)
        away = np.flatnonzero(pressed > 0.0)[-1] + 3
        invariant = (r.tension + r.bending_moment**2 / (2.0 * bending))[away:-2] / force
        worst = float(invariant[np.abs(invariant - 1.0).argmax()])
        quantities.append(Quantity("(T + M^2 / 2 B) / T_end off contact, worst", worst, 1.0, 0.1))
    return quantities


_LAW = "mu a Lambda^2 + Lambda = mu (1 - a)"

CASES = [
    Case(
        "capstan",
        partial(moulded, 0.33),
        "half a turn, T >> B / rho^2: a rod curved by nature",
        _LAW,
        "40 x 12 and tails, h = 1, one point along; ramp 0.05, stick 0.025 mm",
        "moulded",
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
        "a frictionless rod hung over a drum by its ends",
        "B / 2 rho^2",
        "hex8-reduced, 100 x 12, h = 2; ramp 0.05 mm",
    ),
]
