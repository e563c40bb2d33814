"""Straight rods, and solves of which the cases with closed forms are made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from knotfem.contact.samples import Samples
from knotfem.contact.tube import make_samples, make_tubes
from knotfem.contact.tube_pairs import TubeSurface
from knotfem.geometry.slices import Slices
from knotfem.mesh.make_section import section_of
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section
from knotfem.models.material import NeoHooke
from knotfem.models.solid.body import MERIT_AXIAL_STIFFNESS
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import lumped_mass, make_formulation
from knotfem.scene.elements import ORDERS
from knotfem.scene.stiffness import bending_stiffness
from knotfem.solver.constraints import Prescribed
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton, Solution
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import Motion, State
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep, integrate
from knotfem.solver.system import System
from knotfem.solver.term import Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.axial import AxialStiffness
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
        mesh: in its own numbering.
        first: number of its first node.
        bulk: its hexahedra.
        core: its truss, or None.
        density: [tonne/mm^3].
        bending: E pi r^4 / 4 [N mm^2], to which the facetted section is scaled.
    """

    mesh: RodMesh
    first: int
    bulk: Elasticity
    core: AxialStiffness | None
    density: float
    bending: float

    @property
    def terms(self) -> list[Term]:
        """Bulk and core."""
        return [self.bulk] if self.core is None else [self.bulk, self.core]

    @property
    def sections(self) -> np.ndarray:
        """Nodes of each cross-section, shape [slices + 1, nodes of a section]."""
        return self.mesh.section_nodes + self.first

    @property
    def axis(self) -> np.ndarray:
        """Nodes on the centreline, shape [slices + 1]."""
        return self.mesh.axis_nodes + self.first

    @property
    def edges(self) -> np.ndarray:
        """Nodes of the centreline's edges, shape [slices, 2]."""
        return np.stack([self.axis[:-1], self.axis[1:]], axis=1)

    @property
    def section_of_node(self) -> np.ndarray:
        """Cross-section of each node, counted from the start of this rod, shape [nodes of this rod]."""
        return np.repeat(np.arange(self.mesh.slices + 1), self.mesh.section_nodes.shape[1])

    @property
    def points(self) -> np.ndarray:
        """Nodes of the section [mm], shape [nodes of a section, 2]."""
        return self.mesh.nodes[: len(self.mesh.section.points), :2]

    @property
    def mass(self) -> np.ndarray:
        """Lumped [tonne], shape [nodes of this rod]."""
        local = self.bulk.elements - self.first
        return lumped_mass(local, self.bulk.formulation, self.density, len(self.mesh.nodes), self.bulk.heights)

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
        """Fraction of a uniform traction on each node of a section, shape [nodes of a section]."""
        weights = lumped_mass(self.bulk.elements[:1] - self.first, self.bulk.formulation, 1.0, len(self.mesh.nodes))
        weights = weights[: len(self.points)]
        return weights / weights.sum()

    def couple_weights(self, axis: int) -> np.ndarray:
        """Weights, proportional to a section coordinate, of axial forces that make a unit moment about the other."""
        traction = self.end_weights * self.points[:, axis]
        return traction / float(traction @ self.points[:, axis])


def make_rod(
    length: float,
    slices: int | Slices,
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
    """A straight rod of neo-Hookean hexahedra.

    Args:
        length: [mm].
        slices: number of slices of one length, or the slices.
        section: cross-section, or the number of its quadrilaterals.
        radius: [mm].
        youngs: E [MPa].
        poisson: Poisson's ratio.
        element: one of `knotfem.scene.elements.ORDERS`.
        core_stiffness: EA of the core [N]; 0 for none.
        density: [tonne/mm^3].
        first: number of its first node.
        match_bending: whether the facetted section is scaled to the circle's bending stiffness.
    """
    shape = section_of(section, ORDERS[element]) if isinstance(section, int) else section
    mesh = extrude(shape, radius, length, slices, match_bending=match_bending)
    points = mesh.nodes[: len(shape.points), :2]
    form = make_formulation(element, points[shape.quads], mesh.span * mesh.element_length)
    shear, bulk_modulus = moduli(youngs, poisson)
    bulk = Elasticity(mesh.layers + first, form, NeoHooke(shear), bulk_modulus, mesh.heights)
    core = make_core(mesh.core + first, mesh.lengths, core_stiffness) if core_stiffness > 0.0 else None
    return Rod(mesh, first, bulk, core, density, bending_stiffness(youngs, radius))


def make_core(edges: np.ndarray, length: float | np.ndarray, stiffness: float) -> AxialStiffness:
    """A truss core as in the rods of a scene.

    Args:
        edges: nodes of each edge, shape [edges, 2].
        length: of each when free of stress [mm], one number or shape [edges].
        stiffness: EA [N].
    """
    same = np.ones(len(edges))
    return AxialStiffness("core", edges, length * same, stiffness * same, MERIT_AXIAL_STIFFNESS * same)


def cross_sections(*rods: Rod) -> Sections:
    """Cross-sections over which resultants are summed, of rods numbered one behind the other."""
    counts = [rod.mesh.slices + 1 for rod in rods]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    of_node = [start + rod.section_of_node for start, rod in zip(first, rods, strict=True)]
    return Sections(np.concatenate(of_node), first)


def surfaces(rods: Sequence[Rod], spacing: float) -> tuple[TubeSurface, Samples]:
    """Smooth surface of rods, and samples on it no further apart than `spacing` [mm]."""
    tubes = make_tubes(
        [rod.mesh.ring_nodes + rod.first for rod in rods],
        [rod.axis for rod in rods],
        [Slices(rod.mesh.lengths) for rod in rods],
        [rod.mesh.radius for rod in rods],
        [rod.mesh.radius * rod.mesh.node_scale for rod in rods],
    )
    return TubeSurface(tubes), make_samples(tubes, spacing)


def at_rest(x: np.ndarray, time: float = 0.0) -> State:
    """At x without velocity; all terms begin anew."""
    return State.of(Motion.at_rest(x, time), {})


def static(
    terms: Sequence[Term],
    x: np.ndarray,
    prescribed: Sequence[Prescribed],
    sections: Sections,
    *,
    time: float = 1.0,
    tolerance: float = 1e-9,
    linear: str = "auto",
) -> tuple[np.ndarray, System, Solution]:
    """Equilibrium nearest to x at a time [s], with a tolerance on nodes [N]."""
    system = System(terms, Unknowns(len(x)), make_solver(linear), Scheme(), prescribed)
    step = system.begin(at_rest(x), time)
    newton = Newton(ForceTolerance(tolerance, 100.0 * tolerance), Armijo(whole_below=5.0), largest_move=100.0)
    solution = newton.solve(system, x, step, sections)
    return solution.x, system, solution


def accepted_steps(
    system: System,
    state: State,
    sections: Sections,
    output_times: Sequence[float],
    *,
    first: float,
    largest: float | None = None,
    move: float = 5.0,
    newton: Newton | None = None,
) -> Iterator[AcceptedStep]:
    """Accepted steps from a state to the last of the output times.

    Args:
        system: equations.
        state: where to set out.
        sections: over which resultants are summed.
        output_times: ascending [s].
        first: length of the first step [s].
        largest: longest step [s]; by default the last output time.
        move: of a node in a step that is aimed at [mm].
        newton: solver of a step.
    """
    controller = StepController(first, smallest=1e-6 * first, largest=largest or output_times[-1], move=move)
    start = Continuation.at(state)
    return integrate(system, start, controller, newton or Newton(), sections, np.array(output_times))


def final_state(steps: Iterable[AcceptedStep]) -> State:
    """Take all steps; the state at their end."""
    state = None
    for step in steps:
        state = step.state
    assert state is not None, "no output time lies ahead"
    return state


WHOLE_STEPS = Newton(
    ForceTolerance(node=1e-8, resultant=1e-7),
    Armijo(whole_below=1000.0),
    max_iterations=25,
    largest_move=1000.0,
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
