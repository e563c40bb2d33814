"""Crossed cylinders against Hertz.

Hertz's approach is that of points far inside two half-spaces. Rods of finite radius, held at their axes or ends, are
stiffer by a fifth to a third at these loads. Only the neighbourhood of the contact is therefore free to deform here;
the rest of each rod follows the displacement field of a half-space under the measured contact force.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section
from knotfem.models.material import NeoHooke
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import make_formulation
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.verify.benchmarks.rods import Rod, moduli, surfaces
from knotfem.verify.case import Case, Quantity

RADIUS, YOUNGS, POISSON = 3.0, 1.425, 0.4999
LENGTH = 5.2
FREE_ANGLE = np.pi / 3.0
FREE_DEPTH = 2.4


def sector(around: int, deep: int) -> Section:
    """Part of a disc near angle 0: `deep` rings of quadrilaterals, finer towards the rim, of a regular `around`-gon."""
    radii = 1.0 - FREE_DEPTH / RADIUS * np.linspace(1.0, 0.0, deep + 1) ** 1.5
    angles = 2.0 * np.pi * np.arange(around) / around
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.concatenate([[[0.0, 0.0]], *(radius * circle for radius in radii)])
    half = int(FREE_ANGLE / (2.0 * np.pi) * around)
    i = np.arange(-half, half) % around
    j = (i + 1) % around
    starts = 1 + around * np.arange(deep)
    quads = np.concatenate([np.stack([s + i, s + around + i, s + around + j, s + j], axis=1) for s in starts])
    return Section(points, quads, 0, 1 + around * deep + np.arange(around))


def half_space(points: np.ndarray, force: float, contact_radius: float) -> np.ndarray:
    """Displacements [mm] of an incompressible half-space z > 0 under Hertz's pressure (Boussinesq), shape [n, 3]."""
    rings, spokes = 8, 16
    inside = 1.0 - ((np.arange(rings) + 0.5) / rings) ** (2.0 / 3.0)
    radius = contact_radius * np.sqrt(inside)
    turn = 2.0 * np.pi * np.arange(spokes) / spokes
    spots = (radius[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)).reshape(-1, 2)
    scale = 3.0 * force / len(spots) / (4.0 * np.pi * YOUNGS)
    u = np.zeros_like(points)
    for spot in spots:
        to = points - [spot[0], spot[1], 0.0]
        rho = np.linalg.norm(to, axis=1)[:, None]
        u += scale * (to * to[:, 2:] / rho**3 + np.array([0.0, 0.0, 1.0]) / rho)
    return u


class Crossing:
    """Two rods across each other, touching at the origin; the second above the first."""

    def __init__(self, around: int, deep: int, slices: int, law: Penalty, spacing: float) -> None:
        section = sector(around, deep)
        mesh = extrude(section, RADIUS, LENGTH, slices, match_bending=False)
        shift = np.array([-RADIUS, 0.0, -0.5 * LENGTH])
        own = mesh.nodes + shift
        self.depth = np.stack([own[:, 1], own[:, 2], -own[:, 0]], axis=1)
        lower = np.stack([own[:, 1], own[:, 2], own[:, 0]], axis=1)
        upper = np.stack([own[:, 2], own[:, 1], -own[:, 0]], axis=1)
        self.turns = (np.diag([1.0, 1.0, -1.0]), np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        self.X = np.concatenate([lower, upper])
        self.count = len(own)
        self.rods = [self._rod(mesh, section, first) for first in (0, self.count)]
        self.contact = PairContact(*surfaces(self.rods, spacing), law)
        self.bulks = [rod.bulk for rod in self.rods]
        held = self._held(mesh)
        self.held = np.concatenate([held, held + self.count])
        self.goal = self.X.copy()
        self.system = System(
            [*self.bulks, self.contact],
            Unknowns(2 * self.count),
            make_solver("auto"),
            Scheme(),
            [Prescribed(self.held, lambda time: self.goal[self.held])],
        )
        self.state = State.of(Motion.at_rest(self.X), {})

    def _rod(self, mesh: RodMesh, section: Section, first: int) -> Rod:
        points = RADIUS * section.points
        form = make_formulation("hex8", points[section.quads], mesh.element_length)
        elements = mesh.hexes.reshape(mesh.slices, len(section.quads), 8) + first
        shear, bulk_modulus = moduli(YOUNGS, POISSON)
        bulk = Elasticity(elements, form, NeoHooke(shear), bulk_modulus)
        return Rod(mesh, first, bulk, None, 0.0, 0.0)

    def _held(self, mesh: RodMesh) -> np.ndarray:
        """All nodes but those inside the free part and on its outer surface."""
        quads = mesh.section.quads
        ring, rim = mesh.section.ring, np.isin(quads, mesh.section.ring)
        edges = np.concatenate([np.sort(quads[:, [k, (k + 1) % 4]], axis=1) for k in range(4)])
        edges, times = np.unique(edges, axis=0, return_counts=True)
        border = edges[(times == 1) & ~np.isin(edges, ring).all(axis=1)]
        free = np.setdiff1d(quads[rim].tolist() + quads[~rim].tolist(), border)
        inner = mesh.section_nodes[1:-1][:, free]
        return np.setdiff1d(np.arange(len(mesh.nodes)), inner)

    def press(self, approach: float) -> float:
        """Contact force [N] at a total approach [mm], found by iteration with the far field that belongs to it."""
        combined = YOUNGS / (2.0 * (1.0 - POISSON**2))
        force = 0.0
        newton = Newton(ForceTolerance(1e-7, 1e-5), Armijo(whole_below=0.02), max_iterations=60, largest_move=0.5)
        sections = Sections.single(np.zeros(2 * self.count, dtype=int))
        guess = 4.0 / 3.0 * combined * np.sqrt(RADIUS) * approach**1.5
        for _ in range(4):
            radius = (0.75 * guess * RADIUS / combined) ** (1.0 / 3.0)
            u = half_space(self.depth, guess, radius) - [0.0, 0.0, 0.5 * approach]
            self.goal = self.X + np.concatenate([u @ turn.T for turn in self.turns])
            step = self.system.begin(self.state, 1.0)
            solution = newton.solve(self.system, self.state.x, step, sections)
            self.state = self.system.commit(solution.x, step)
            force = self.force()
            if abs(force / guess - 1.0) < 1e-3:
                break
            guess = force
        return force

    def force(self) -> float:
        """Contact force on the upper rod [N]."""
        residual = np.zeros_like(self.state.x)
        self.contact.assemble(self.state.x, residual, None)
        return -float(residual[self.count :, 2].sum())


def hertz(around: int, deep: int, slices: int, forces: dict[float, tuple[float, float]]) -> list[Quantity]:
    """Contact force at approaches given over the radius, each with its expected value and tolerance."""
    crossing = Crossing(around, deep, slices, Penalty(stiffness=50.0, ramp=0.005), 0.15)
    return [
        Quantity("F [N]", crossing.press(ratio * RADIUS), expected, tolerance, condition=f"delta / r = {ratio:g}")
        for ratio, (expected, tolerance) in forces.items()
    ]


_FORCES = {0.05: (0.1275, 0.05), 0.10: (0.3605, 0.10)}

CASES = [
    Case(
        "hertz",
        partial(hertz, around, deep, slices, _FORCES),
        "crossed cylinders at 90 degrees",
        "F = 4/3 E* sqrt(r) delta^1.5",
        f"hex8, rim {2.0 * np.pi * RADIUS / around:.2f} mm, slices {LENGTH / slices:.2f} mm; 50 MPa/mm, ramp 0.005 mm",
        f"{around}-{slices}",
        slow=around > 48,
    )
    for around, deep, slices in ((48, 6, 16), (64, 8, 24))
]
