"""Straight rods and solves of which the cases are made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.contact.tube import Samples, Tubes, make_samples, make_tubes
from knotfem.mesh.make_section import section_of
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section
from knotfem.models.solid.core import Core
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import lumped_mass, make_formulation
from knotfem.scene.elements import ORDERS
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.newton import Iterations, NewtonSettings, solve
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import March, Progress, StepControl
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart, Term
from knotfem.sparse.linear import make_solver
from knotfem.tie.sweep import swept_state

DENSITY = 1.16e-9
"""Of the paper's elastomer [tonne/mm^3]."""


def moduli(youngs: float, poisson: float) -> tuple[float, float]:
    """Shear and bulk modulus."""
    return youngs / (2.0 * (1.0 + poisson)), youngs / (3.0 * (1.0 - 2.0 * poisson))


@dataclass(eq=False)
class Rod:
    """A straight rod along z, its nodes numbered from `first`.

    Attributes:
        bending: E pi r^4 / 4, which the facetted section is scaled to have.
        sections: nodes of each cross-section, shape [slices + 1, nodes a section].
    """

    mesh: RodMesh
    first: int
    bulk: Elasticity
    core: Core | None
    density: float
    bending: float

    @property
    def effects(self) -> list[Term]:
        return [self.bulk] if self.core is None else [self.bulk, self.core]

    @property
    def sections(self) -> np.ndarray:
        return self.mesh.section_nodes + self.first

    @property
    def axis(self) -> np.ndarray:
        return self.mesh.axis_nodes + self.first

    @property
    def section_index(self) -> np.ndarray:
        """Cross-section of each node, see `newton.out_of_balance`."""
        return np.repeat(np.arange(self.mesh.slices + 1), self.mesh.section_nodes.shape[1])

    @property
    def points(self) -> np.ndarray:
        """Nodes of the section [mm], shape [nodes a section, 2]."""
        return self.mesh.nodes[: len(self.mesh.section.points), :2]

    @property
    def mass(self) -> np.ndarray:
        """Lumped [tonne], shape [nodes of this rod]."""
        local = self.bulk.elements - self.first
        return lumped_mass(local, self.bulk.formulation, self.density, len(self.mesh.nodes))

    @property
    def area(self) -> float:
        """Of the facetted section [mm^2]."""
        return float(self.bulk.formulation.weights.sum()) / (self.mesh.span * self.mesh.element_length)

    @property
    def youngs(self) -> float:
        """E [MPa]."""
        G, K = self.bulk.shear_modulus, self.bulk.bulk_modulus
        return 9.0 * K * G / (3.0 * K + G)

    @property
    def end_weights(self) -> np.ndarray:
        """Share of each node of a section in a uniform traction."""
        share = lumped_mass(self.bulk.elements[:1] - self.first, self.bulk.formulation, 1.0, len(self.mesh.nodes))
        share = share[: len(self.points)]
        return share / share.sum()

    def couple_weights(self, axis: int) -> np.ndarray:
        """Weights, proportional to a section coordinate, of axial forces that make a unit moment about the other."""
        traction = self.end_weights * self.points[:, axis]
        return traction / float(traction @ self.points[:, axis])


def make_rod(
    length: float,
    slices: int,
    *,
    section: int | Section = 12,
    radius: float = 3.0,
    youngs: float = 1.25,
    poisson: float = 0.4999,
    element: str = "hex8-reduced",
    core_stiffness: float = 0.0,
    density: float = DENSITY,
    first: int = 0,
    match_bending: bool = True,
) -> Rod:
    shape = section_of(section, ORDERS[element]) if isinstance(section, int) else section
    mesh = extrude(shape, radius, length, slices, match_bending=match_bending)
    points = mesh.nodes[: len(shape.points), :2]
    form = make_formulation(element, points[shape.quads], mesh.span * mesh.element_length)
    elements = mesh.layers + first
    core = Core(mesh.core + first, mesh.element_length, core_stiffness) if core_stiffness > 0.0 else None
    bending = youngs * np.pi * radius**4 / 4.0
    return Rod(mesh, first, Elasticity(elements, form, *moduli(youngs, poisson)), core, density, bending)


def surfaces(rods: Sequence[Rod], spacing: float) -> tuple[Tubes, Samples]:
    """Smooth surfaces of rods and samples on them."""
    tubes = make_tubes(
        [rod.mesh.ring_nodes + rod.first for rod in rods],
        [rod.axis for rod in rods],
        [rod.mesh.element_length for rod in rods],
        [rod.mesh.radius for rod in rods],
        [rod.mesh.radius * rod.mesh.node_scale for rod in rods],
    )
    return tubes, make_samples(tubes, spacing)


def static(
    effects: Sequence[Term],
    x: np.ndarray,
    prescribed: Sequence[Prescribed],
    sections: np.ndarray,
    *,
    time: float = 1.0,
    tolerance: float = 1e-9,
    linear: str = "auto",
) -> tuple[np.ndarray, System, Iterations]:
    """Equilibrium nearest to x."""
    system = System(effects, len(x), make_solver(linear), Scheme(), prescribed)
    start = StepStart(Motion.at_rest(x), time)
    system.begin(start)
    settings = NewtonSettings(
        force_tolerance=tolerance, resultant_tolerance=100.0 * tolerance, largest_move=100.0, endgame_move=5.0
    )
    x, took = solve(system, x, start, settings, sections)
    return x, system, took


def march(
    system: System,
    motion: Motion,
    sections: np.ndarray,
    stops: Sequence[float],
    *,
    first: float,
    largest: float | None = None,
    move: float = 5.0,
    settings: NewtonSettings | None = None,
) -> March:
    """Steps from a motion to the last of the stops."""
    control = StepControl(first=first, smallest=1e-6 * first, largest=largest or stops[-1], move=move)
    return March(system, Progress.at(motion), control, settings or NewtonSettings(), sections, np.array(stops))


def arrive(steps: March) -> np.ndarray:
    """Take all steps of a march; positions at its end [mm], shape [nodes, 3]."""
    for _ in steps:
        pass
    return steps.progress.motion.x


WHOLE_STEPS = NewtonSettings(
    force_tolerance=1e-8, resultant_tolerance=1e-7, largest_move=1000.0, endgame_move=1000.0, max_iterations=25
)
"""For slender rods without contact: Newton steps as they come."""


def beam_clamp(rod: Rod, end: int = 0) -> list[Prescribed]:
    """Holds a section as beam theory does: plane, upright and in place, but free to bulge.

    A section held as a whole is stiffer, by about 0.13 r of the rod's length. Only the axis node carries a transverse
    force, so one that acts must be met by an `EndForce` on the section.
    """
    X, nodes = rod.mesh.nodes, rod.sections[end]
    axis, spoke = rod.axis[[end]], nodes[rod.mesh.section.ring[:1]]
    return [
        Prescribed(nodes, lambda time: X[nodes - rod.first], components=(False, False, True)),
        Prescribed(axis, lambda time: X[axis - rod.first]),
        Prescribed(spoke, lambda time: X[spoke - rod.first], components=(False, True, False)),
    ]


def bent_into_arc(rod: Rod, angle: float) -> np.ndarray:
    """Positions of a rod swept onto a circle in the x-z plane on which its end turns by an angle."""
    turn = angle * np.linspace(0.0, 1.0, rod.mesh.slices + 1)
    radius = rod.mesh.element_length / (2.0 * np.sin(0.5 * angle / rod.mesh.slices))
    points = radius * np.stack([1.0 - np.cos(turn), np.zeros_like(turn), np.sin(turn)], axis=1)
    zero, one = np.zeros_like(turn), np.ones_like(turn)
    frames = np.stack(
        [
            np.stack([np.cos(turn), zero, -np.sin(turn)], axis=1),
            np.stack([zero, one, zero], axis=1),
            np.stack([np.sin(turn), zero, np.cos(turn)], axis=1),
        ],
        axis=1,
    )
    return swept_state(points, frames, rod.points).reshape(-1, 3)
