"""From the rods of a scene to their meshes, hexahedra and cores."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
from knotfem.mesh.make_section import chosen_section, other_count
from knotfem.mesh.quadratic import quadratic
from knotfem.mesh.rod import RodMesh, extrude
from knotfem.mesh.section import Section
from knotfem.models.base import EndNodes
from knotfem.models.centreline import Centreline, centrelines_of, slices_of
from knotfem.models.material import Material, NeoHooke
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.formulation import lumped_mass, make_formulation
from knotfem.scene.elements import ORDERS
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod
from knotfem.solver.nonlinear.tolerance import Sections
from knotfem.solver.term import Term
from knotfem.solver.unknowns import Unknowns

if TYPE_CHECKING:
    from knotfem.models.solid.projection import Projection
    from knotfem.terms.axial import AxialStiffness

MERIT_AXIAL_STIFFNESS = 50.0
"""Moderate axial stiffness of the core [N] in the line search's merit; the true one rejects every rotation."""


@dataclass(frozen=True, eq=False)
class SolidRod:
    """One rod in the numbering of the whole model.

    Attributes:
        scene: what the user asked for.
        mesh: in its own numbering.
        first: number of its first node.
        target: centreline of the tied rod.
        bulk: its hexahedra.
        core: its truss, or None.
        section_nodes: shape [sections, nodes of a section].
        section_points: of the section [mm], shape [nodes of a section, 2].
    """

    scene: Rod
    mesh: RodMesh
    first: int
    target: Centreline
    bulk: Elasticity
    core: AxialStiffness | None
    section_nodes: np.ndarray
    section_points: np.ndarray

    @cached_property
    def projection(self) -> Projection:
        """From integration points to nodes; made when fields are first written."""
        from knotfem.models.solid.projection import Projection

        return Projection(self.mesh, self.bulk.formulation)

    @property
    def axis_nodes(self) -> np.ndarray:
        """Nodes on the centreline, shape [sections]."""
        return self.section_nodes[:, self.mesh.section.axis]

    def lumped(self, density: float) -> np.ndarray:
        """Mass of each node at this density, shape [nodes of the rod]."""
        bulk = self.bulk
        return lumped_mass(bulk.elements - self.first, bulk.formulation, density, len(self.mesh.nodes), bulk.heights)

    def end(self, side: str) -> EndNodes:
        """Nodes of the section at "start" or "end", with the weights of a force that stretches bulk and core alike."""
        nodes, axis = self.section_nodes[0 if side == "start" else -1], self.axis_nodes
        outer, inner = (axis[0], axis[1]) if side == "start" else (axis[-1], axis[-2])
        return EndNodes(nodes, self._end_weights(), int(outer), int(inner))

    def _end_weights(self) -> np.ndarray:
        first = self.bulk.elements[:1] - self.first
        weights = lumped_mass(first, self.bulk.formulation, 1.0, len(self.mesh.nodes))[: len(self.section_points)]
        weights *= float(self.bulk.formulation.weights.sum()) / (
            self.mesh.span * self.mesh.element_length * weights.sum()
        )
        weights *= self.scene.material.youngs_modulus
        weights[self.mesh.section.axis] += self.scene.core_axial_stiffness
        return weights / weights.sum()


@dataclass(eq=False)
class Body:
    """All rods of a scene.

    Attributes:
        scene: what the user asked for.
        rods: in the scene's order.
        unknowns: of all nodes, damped by their fractions of the volume.
        sections: cross-sections of all rods.
        warnings: what deserves one.
    """

    scene: Scene
    rods: list[SolidRod]
    unknowns: Unknowns
    sections: Sections
    warnings: list[str]

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.unknowns.nodes

    @cached_property
    def mass(self) -> np.ndarray:
        """Lumped, of all nodes [tonne]; made when a term first asks for it."""
        return np.concatenate([rod.lumped(rod.scene.material.density) for rod in self.rods])

    @property
    def hexes(self) -> int:
        """Number of hexahedra."""
        return sum(len(rod.mesh.hexes) for rod in self.rods)

    @property
    def axis_edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of the centrelines' edges, shape [edges, 2], and their lengths [mm], shape [edges]."""
        edges = [np.stack([rod.axis_nodes[:-1], rod.axis_nodes[1:]], axis=1) for rod in self.rods]
        return np.concatenate(edges), np.concatenate([rod.mesh.lengths for rod in self.rods])

    @property
    def elastic(self) -> list[Term]:
        """Bulk and core of all rods."""
        return [term for rod in self.rods for term in (rod.bulk, rod.core) if term is not None]


def mesh_of(rod: Rod, slices: Slices, section: Section | None = None) -> RodMesh:
    """Hexahedra and truss of a rod, straight.

    Args:
        rod: what the user asked for.
        slices: of the rod.
        section: instead of what the user asked for.

    Raises:
        InputError: no such section.
    """
    order = ORDERS[rod.mesh.element]
    if section is None:
        section = chosen_section(rod.mesh.section, rod.mesh.section_elements, order)
    elif section.order < order:
        section = quadratic(section)
    return extrude(section, rod.radius, rod.length, slices, match_bending=rod.mesh.match_bending_stiffness)


def meshes_of(scene: Scene) -> list[tuple[RodMesh, int]]:
    """Meshes of all rods of a scene, as `mesh_of`, each with the number of its first node in the whole model."""
    meshes = [mesh_of(rod, slices) for rod, slices in zip(scene.rods, slices_of(scene), strict=True)]
    return list(zip(meshes, accumulate((len(mesh.nodes) for mesh in meshes[:-1]), initial=0), strict=True))


def build_body(scene: Scene, section: Section | None = None, materials: Mapping[str, Material] | None = None) -> Body:
    """Mesh all rods of a scene.

    Args:
        scene: what the user asked for.
        section: of all rods, instead of the scene's.
        materials: laws of the user's own by the rod's name.

    Raises:
        InputError: a centreline or a section that cannot be.
    """
    _refuse_mixed_orders(scene)
    rods: list[SolidRod] = []
    volumes: list[np.ndarray] = []
    sections: list[np.ndarray] = []
    starts = [0]
    first = 0
    for rod, target in zip(scene.rods, centrelines_of(scene), strict=True):
        made = _solid_rod(rod, target, first, section, (materials or {}).get(rod.name))
        rods.append(made)
        volumes.append(made.lumped(1.0))
        sections.append(starts[-1] + np.repeat(np.arange(made.mesh.slices + 1), len(made.section_points)))
        starts.append(starts[-1] + made.mesh.slices + 1)
        first += len(made.mesh.nodes)
    volume = np.concatenate(volumes)
    warnings = [warning for rod in rods for warning in rod.target.warnings]
    if section is None:
        warnings += [said for rod in scene.rods if (said := _said_of_section(rod)) is not None]
    unknowns = Unknowns(volume.size, damping_weights=volume / volume.sum())
    return Body(scene, rods, unknowns, Sections(np.concatenate(sections), np.array(starts[:-1])), warnings)


def _solid_rod(rod: Rod, target: Centreline, first: int, section: Section | None, law: Material | None) -> SolidRod:
    mesh = mesh_of(rod, target.slices, section)
    points = mesh.nodes[: len(mesh.section.points), :2]
    form = make_formulation(rod.mesh.element, points[mesh.section.quads], mesh.span * mesh.element_length)
    material = NeoHooke(rod.material.shear_modulus) if law is None else law
    bulk = Elasticity(mesh.layers + first, form, material, rod.material.bulk_modulus, mesh.heights)
    core = None
    if rod.core is not None:
        from knotfem.terms.axial import AxialStiffness

        edges, stiffness = mesh.core + first, np.full(len(mesh.core), rod.core_axial_stiffness)
        merit = np.full(len(edges), MERIT_AXIAL_STIFFNESS)
        core = AxialStiffness("core", edges, mesh.lengths.copy(), stiffness, merit)
    return SolidRod(rod, mesh, first, target, bulk, core, mesh.section_nodes + first, points)


def _said_of_section(rod: Rod) -> str | None:
    """What must be said where the cross-section has not the number of elements asked for."""
    if rod.mesh.section is not None:
        return None
    said = other_count(rod.mesh.section_elements, ORDERS[rod.mesh.element])
    return said and f"{rod.name}: {said}"


def _refuse_mixed_orders(scene: Scene) -> None:
    """All rods share one series of cells."""
    first = scene.rods[0].mesh.element
    for number, rod in enumerate(scene.rods):
        if ORDERS[rod.mesh.element] != ORDERS[first]:
            problem = "linear and quadratic elements in one scene"
            raise InputError(problem, key=f"rods.{number}.mesh.element", found=rod.mesh.element, expected=first)
