"""From a scene to the numerics: meshes, effects and constraints of its rods."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from knotfem import shipped
from knotfem.errors import InputError
from knotfem.mesh.quadratic import five, quadratic
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section, read_section
from knotfem.models.centreline import Centreline, centrelines_of
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import lumped_mass, make_formulation, order
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.solver.term import Term

if TYPE_CHECKING:
    from knotfem.contact.penalty import Penalty
    from knotfem.models.solid.core import Core


@dataclass(frozen=True, eq=False)
class RodBody:
    """One rod in the numbering of the whole model.

    Attributes:
        scene: what the user asked for.
        mesh: in its own numbering.
        first: number of its first node.
        target: centreline of the tied rod.
        bulk: its hexahedra.
        core: its truss, or None.
        section_nodes: shape [sections, nodes a section].
        section_points: of the section [mm], shape [nodes a section, 2].
    """

    scene: Rod
    mesh: RodMesh
    first: int
    target: Centreline
    bulk: Elasticity
    core: Core | None
    section_nodes: np.ndarray
    section_points: np.ndarray

    @property
    def axis_nodes(self) -> np.ndarray:
        """Nodes on the centreline, shape [sections]."""
        return self.section_nodes[:, self.mesh.section.axis]

    @property
    def axial_stiffness(self) -> float:
        """EA of bulk and core [N]."""
        area = float(self.bulk.formulation.weights.sum()) / (self.mesh.span * self.mesh.element_length)
        return self.scene.material.youngs_modulus * area + (self.core.axial_stiffness if self.core else 0.0)

    def lumped(self, density: float) -> np.ndarray:
        """Mass of each node at this density, shape [nodes of the rod]."""
        return lumped_mass(self.bulk.elements - self.first, self.bulk.formulation, density, len(self.mesh.nodes))

    def end_nodes(self, side: str) -> np.ndarray:
        """Nodes of the section at "start" or "end"."""
        return self.section_nodes[0 if side == "start" else -1]

    def end_weights(self) -> np.ndarray:
        """Share of each node of an end section in a force that stretches bulk and core alike, summing to one."""
        first = self.bulk.elements[:1] - self.first
        weights = lumped_mass(first, self.bulk.formulation, 1.0, len(self.mesh.nodes))[: len(self.section_points)]
        weights *= float(self.bulk.formulation.weights.sum()) / (
            self.mesh.span * self.mesh.element_length * weights.sum()
        )
        weights *= self.scene.material.youngs_modulus
        if self.core is not None:
            weights[self.mesh.section.axis] += self.core.axial_stiffness
        return weights / weights.sum()


@dataclass(eq=False)
class Body:
    """All rods of a scene.

    Attributes:
        scene: what the user asked for.
        rods: in the scene's order.
        shift_weights: share of each node in the volume, summing to one.
        sections: cross-section of each node, counted through all rods.
    """

    scene: Scene
    rods: list[RodBody]
    shift_weights: np.ndarray
    sections: np.ndarray
    warnings: list[str] = field(default_factory=list)

    @property
    def nodes(self) -> int:
        return self.shift_weights.size

    @cached_property
    def mass(self) -> np.ndarray:
        """Lumped, of all nodes [tonne]; made when an effect first asks for it."""
        return np.concatenate([rod.lumped(rod.scene.material.density) for rod in self.rods])

    @property
    def hexes(self) -> int:
        return sum(len(rod.mesh.hexes) for rod in self.rods)

    @property
    def law(self) -> Penalty:
        """Penalty law in units of the thinnest rod and the softest material."""
        from knotfem.contact.penalty import Penalty

        c, d = self.scene.contact, self.scene.diameter
        stiffness = c.stiffness_over_modulus * self.scene.youngs_modulus / d
        return Penalty(stiffness, c.ramp_over_diameter * d, c.stick_over_diameter * d)

    @property
    def elastic(self) -> list[Term]:
        """Bulk and core of all rods."""
        return [effect for rod in self.rods for effect in (rod.bulk, rod.core) if effect is not None]

    def centrelines(self, x: np.ndarray) -> list[np.ndarray]:
        """Positions of the axis nodes of each rod, shapes [sections, 3]."""
        return [x[rod.axis_nodes] for rod in self.rods]


def shipped_section(elements: int, degree: int) -> Section:
    """A ready-made cross-section.

    Args:
        elements: number of quadrilaterals.
        degree: 1 for quadrilaterals of four nodes, 2 of nine.

    Raises:
        InputError: no such section.
    """
    if degree == 2 and elements == 5:
        return five()
    section = read_section(shipped.section_path(elements))
    return section if degree == 1 else quadratic(section)


def mesh_of(rod: Rod, section: Section | None = None) -> RodMesh:
    """Hexahedra and truss of a rod, straight.

    Args:
        rod: what the user asked for.
        section: instead of the shipped one.

    Raises:
        InputError: no such section.
    """
    degree = order(rod.mesh.element)
    if section is None:
        section = shipped_section(rod.mesh.section_elements, degree)
    elif section.order < degree:
        section = quadratic(section)
    return extrude(section, 0.5 * rod.diameter, rod.length, rod.slices, match_bending=rod.mesh.match_bending_stiffness)


def build_body(scene: Scene, section: Section | None = None) -> Body:
    """Mesh all rods of a scene.

    Args:
        scene: what the user asked for.
        section: of all rods, instead of the shipped one.

    Raises:
        InputError: a centreline or a section that cannot be.
    """
    _refuse_mixed_orders(scene)
    rods, volumes, sections = [], [], []
    first = 0
    for rod, target in zip(scene.rods, centrelines_of(scene), strict=True):
        mesh = mesh_of(rod, section)
        slices = mesh.slices
        points = mesh.nodes[: len(mesh.section.points), :2]
        form = make_formulation(rod.mesh.element, points[mesh.section.quads], mesh.span * mesh.element_length)
        elements = mesh.layers + first
        material = rod.material
        bulk = Elasticity(elements, form, material.shear_modulus, material.bulk_modulus)
        core = None
        if rod.core is not None:
            from knotfem.models.solid.core import Core

            core = Core(mesh.core + first, mesh.element_length, rod.core.axial_stiffness)
        body = RodBody(rod, mesh, first, target, bulk, core, mesh.section_nodes + first, points)
        rods.append(body)
        volumes.append(body.lumped(1.0))
        offset = 0 if not sections else int(sections[-1][-1]) + 1
        sections.append(offset + np.repeat(np.arange(slices + 1), len(points)))
        first += len(mesh.nodes)
    volume = np.concatenate(volumes)
    return Body(
        scene,
        rods,
        volume / volume.sum(),
        np.concatenate(sections),
        [warning for rod in rods for warning in rod.target.warnings],
    )


def _refuse_mixed_orders(scene: Scene) -> None:
    """All rods share one series of cells."""
    first = scene.rods[0].mesh.element
    for number, rod in enumerate(scene.rods):
        if order(rod.mesh.element) != order(first):
            problem = "linear and quadratic elements in one scene"
            raise InputError(problem, key=f"rods.{number}.mesh.element", found=rod.mesh.element, expected=first)
