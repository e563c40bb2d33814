"""Loose open torus knots against Audoly's law, and longer braids against Jawed's.

Audoly, Clauvelin and Neukirch (2007): F r^2/B = eps^4/2 + mu sigma eps^3 with eps = sqrt(r/R), R the radius of the
loop, sigma = 0.492 (3_1), 1.475 (5_1), the first terms of an expansion in eps, in which all radii of the loop are one.
Two of them here: R_c of the loop's mean curvature between its contacts, R_d = drawn length / (2 pi). The energy depends
on the drawn length and on r alone; F and half the total contact force N are its derivatives, whence F = F_0 + mu N and,
by the drawn length, F_0 r^2/B = eps^4/2 (1 + 6 sigma eps/pi + ...). The last lines give what the ratios tend to.

Jawed et al. (2015), long braids: F/(B k^2) = 2 pi n mu r k, friction alone, with k the wave number of the braid, which
is (sqrt(12) r R)^(-1/2) as eps goes to 0. Two statements: each is looked at by itself, F also with the k that is found.

Run with: python benchmarks/rod_overhand.py [3_1] [5_1] [braids]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rod_common import YOUNGS, Phase, rubber, table
from scipy.interpolate import CubicSpline

from knotfem.contact.collect import contact_report
from knotfem.contact.curve_pairs import hertz_line_stiffness
from knotfem.contact.report import ContactReport
from knotfem.geometry.vectors import unit_vectors
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.spec import ContactSpec
from knotfem.scene.stiffness import axial_stiffness
from knotfem.solver.constraints import driven, held
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.schemes import BackwardEuler
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.term import Role
from knotfem.terms.inertia import Inertia
from knotfem.theory import braid_force, braid_wave_number, loose_knot_contact_force, loose_knot_force
from knotfem.theory.loose import SIGMA
from knotfem.verify.benchmarks.wraps import torus_knot

ALONG = np.array([1.0, 0.0, 0.0])
RANGES = (
    (345.0, (300.0,)), (230.0, (200.0,)), (150.0, (130.0,)), (95.0, (80.0,)), (62.0, (50.0,)), (45.0, (30.0, 20.0)),
)  # fmt: skip
"""First radius of a loop and those at which it is looked at, all in radii of the rod; each range has its own rod."""
RESOLUTION = 5.0
"""Segments on a length sqrt(r R) of the braid at the tightest."""


@dataclass(frozen=True)
class Frame:
    """A knot on its way.

    Attributes:
        curved: R_c, in radii of the rod.
        drawn: R_d, likewise.
        force: F [B/r^2].
        normal: N [B/r^2].
        sliding: fraction of the contact force that slides.
        drag: largest force of inertia and drag along the rod over F.
        wave: wave number of the braid [1/r].
    """

    curved: float
    drawn: float
    force: float
    normal: float
    sliding: float
    drag: float
    wave: float


def tighten(n: int, friction: float, first: float, loops: Sequence[float]) -> list[Frame]:
    """Pull a knot of r = 1 mm and loop radius `first` [mm] until that is `loops` [mm], with drag below 1 % of F."""
    length = 2.0 * np.pi * first * 1.3 + 10.0 * (2 * n + 1) * np.sqrt(first)
    segments = int(RESOLUTION * length / np.sqrt(loops[-1]))
    spec = rubber(torus_knot(n, 1.0, first, segments, length), 1.0, 200.0 + axial_stiffness(YOUNGS, 1.0))
    contact = ContactSpec(
        hertz_line_stiffness(YOUNGS, 0.5), friction, ramp=1.0 / 30.0, stick=1.0 / 30.0, sample_spacing=0.25
    )
    rods, ends = DiscreteRods([spec], contact, drag=20.0), np.array([0, segments])
    phase = Phase(rods, rods.initial, [held(ends, rods.initial.x[ends, :3])], scheme=BackwardEuler())
    _rest(phase, spec.bending)
    result = []
    for loop in loops:
        state, speed = phase.state, 8.0 * min(1.0, (30.0 / loop) ** 3)
        place, since = state.x[ends, :3], state.time
        way = length - 2.0 * np.pi * loop - float(np.linalg.norm(place[1] - place[0]))
        apart = 0.5 * np.array([[-1.0], [1.0]]) * ALONG
        pull = driven(ends, place, apart, lambda now, since=since, speed=speed: speed * (now - since))
        phase = Phase(rods, state, [pull], scheme=BackwardEuler(), drag=0.2)
        move = max(4.0, 0.05 * loop)
        controller = StepController(0.08 / speed, 1e-8, 2.0 * move / speed, move)
        for _ in phase.steps(controller, _newton(1e-8 * spec.bending), since + way / speed):
            pass
        result.append(_frame(rods, phase, spec.bending))
    return result


def _newton(tolerance: float) -> Newton:
    """In units of a rod of r = 1 mm."""
    return Newton(tolerance=ForceTolerance.of(tolerance), line_search=Armijo(whole_below=0.01), largest_move=0.5)


def _rest(phase: Phase, bending: float) -> None:
    """Wait until inertia and drag carry less than 1e-4 B/r^2 and hardly anything moves, ten seconds at most."""
    for step in phase.steps(StepController(0.01, 1e-8, 10.0, 1.0), _newton(1e-6 * bending), 10.0):
        (inertia,) = (term for term in phase.system.terms if isinstance(term, Inertia))
        elastic = sum(term.energy(step.state.x) for term in phase.system.having(Role.ELASTIC))
        if _dynamic(phase) < 1e-4 * bending and inertia.kinetic_energy(step.state.v) < 1e-6 * elastic:
            return


def _dynamic(phase: Phase) -> float:
    """Largest running sum of inertia and drag along the rod [N]."""
    forces, roles = phase.system.forces(phase.state.x), (Role.INERTIA, Role.RESISTANCE)
    moving = [forces[label] for label, term in phase.system.labels.items() if term.role in roles]
    return phase.sections.largest_sum(np.sum(moving, axis=0))


def _frame(rods: DiscreteRods, phase: Phase, scale: float) -> Frame:
    x, c, h = phase.state.x, contact_report(rods.terms), rods.layout.spacing[0]
    along = phase.system.residual(x)[[0, -1], 0]
    force = 0.5 * (along[1] - along[0])
    middle = 0.5 * (c.arclength.min() + c.arclength.max())
    before, after = c.arclength[c.arclength < middle].max(), c.arclength[c.arclength > middle].min()
    curvature = rods.bend.curvature(x)[int(before / h) + 1 : int(after / h) - 1].mean()
    drawn = h * rods.layout.edges.size - float(np.linalg.norm(x[-1, :3] - x[0, :3]))
    sliding = float(c.normal_force[c.slides].sum() / c.normal_force.sum())
    return Frame(
        1.0 / curvature,
        drawn / (2.0 * np.pi),
        force / scale,
        c.normal_force.sum() / scale,
        sliding,
        _dynamic(phase) / force,
        _wave_number(c, x[:, :3], h),
    )


def _wave_number(c: ContactReport, x: np.ndarray, h: float) -> float:
    """How fast the two strands turn about each other [1/mm], in the middle half of the braid."""
    first = c.arclength < c.other_arclength
    here, there = c.arclength[first], c.other_arclength[first]
    chosen = np.abs(here - 0.5 * (here.min() + here.max())) < 0.25 * np.ptp(here)
    order = np.argsort(here[chosen])
    here, there = here[chosen][order], there[chosen][order]
    curve = CubicSpline(h * np.arange(len(x)), x)
    across, axis = unit_vectors(curve(there) - curve(here)), unit_vectors(curve(here, 1) + curve(there, 1))
    way = np.linalg.norm(np.diff(0.5 * (curve(here) + curve(there)), axis=0), axis=1)
    turned = np.einsum("ij,ij->i", np.cross(across[:-1], across[1:]), 0.5 * (axis[:-1] + axis[1:]))
    return float(abs(turned.sum()) / way.sum())


def limit(eps: np.ndarray, ratio: np.ndarray) -> tuple[float, float]:
    """Value and slope at eps = 0 of a parabola through the four smallest."""
    chosen = np.argsort(eps)[:4]
    fit = np.polynomial.Polynomial.fit(eps[chosen], ratio[chosen], 2).convert().coef
    return float(fit[0]), float(fit[1])


def audoly(n: int, coefficients: Sequence[float]) -> None:
    rows, smooth = [], []
    for mu in coefficients:
        frames = [frame for first, loops in RANGES for frame in tighten(n, mu, first, loops)]
        if mu == 0.0:
            smooth = frames
        for f, plain in zip(frames, smooth, strict=True):
            c, d = f.curved**-0.5, f.drawn**-0.5
            part = (f.force - plain.force) / (mu * f.normal) if mu else np.nan
            row = [mu, c, f.force / loose_knot_force(c, mu, n), f.normal / loose_knot_contact_force(c, n)]
            row += [d, f.force / loose_knot_force(d, mu, n), f.normal / loose_knot_contact_force(d, n)]
            rows.append([*row, part, f.sliding, f.drag])
    names = ("mu", "eps_c", "F/law", "N/law", "eps_d", "F/law", "N/law", "(F-F0)/mu N", "sliding", "drag/F")
    table(f"open (2, {2 * n + 1}) torus knot against Audoly's law", names, rows)
    found = np.array(rows)[: len(smooth)]
    for name, k in (("mean curvature", 1), ("drawn length", 4)):
        bending, normal = limit(found[:, k], found[:, k + 1]), limit(found[:, k], found[:, k + 2])
        print(f"by {name}: F_0/law tends to {bending[0]:.3f} + {bending[1]:.2f} eps", end=", ")
        print(f"N/law to {normal[0]:.3f} + {normal[1]:.2f} eps")
    print(f"6 sigma/pi = {6.0 * SIGMA[n] / np.pi:.2f}")


def jawed(n: int, friction: float) -> None:
    """Friction is mu times the normal force without it, to first order; and what an end needs more with it."""
    rows = []
    for first, loops in RANGES:
        pairs = zip(tighten(n, 0.0, first, loops), tighten(n, friction, first, loops), strict=True)
        for smooth, rough in pairs:
            k = braid_wave_number(rough.curved**-0.5)
            loss = (rough.force - smooth.force) / friction
            row = [rough.curved**-0.5, rough.wave / k]
            for wave, normal in ((k, loss), (rough.wave, loss), (smooth.wave, smooth.normal)):
                row.append(normal / braid_force(wave, 1.0, n))
            rows.append([*row, rough.sliding, rough.drag])
    names = ("eps_c", "k/law", "F/law", "F/law, k found", "N/law, k found, mu = 0", "sliding", "drag/F")
    table(f"braid of n = {n} against Jawed's law, mu = {friction}", names, rows)


def main() -> None:
    wanted = sys.argv[1:] or ["3_1", "5_1", "braids"]
    if "3_1" in wanted:
        audoly(1, (0.0, 0.05, 0.1))
    if "5_1" in wanted:
        audoly(2, (0.0, 0.05, 0.1))
    if "braids" in wanted:
        for n in (2, 3):
            jawed(n, 0.1)


if __name__ == "__main__":
    main()
