"""The straight rod: hexahedra extruded from a cross-section, trusses along the axis."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices, equal_slices
from knotfem.mesh.section import Section
from knotfem.mesh.section_properties import scale_for_bending

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CUT_QUAD = np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]])
_CUT = np.concatenate([np.hstack([9 * k + _CUT_QUAD, 9 * (k + 1) + _CUT_QUAD]) for k in (0, 1)])
_VTK_27 = np.array([0, 1, 2, 3, 18, 19, 20, 21, 4, 5, 6, 7, 22, 23, 24, 25, 9, 10, 11, 12, 16, 14, 13, 15, 8, 26, 17])


@dataclass(frozen=True, eq=False)
class RodMesh:
    """A straight rod from 0 to its length along e_z, in mm.

    With n slices and m section nodes, node `i m + k` is node k of section i, and hexahedron `i q + e` is
    quadrilateral e of slice i.

    Attributes:
        nodes: reference positions in mm, shape ((n + 1) m, 3).
        hexes: nodes of each hexahedron, level after level: bottom face counter-clockwise seen from +z, then the top
            face (the order of VTK, Abaqus and Gmsh), slice after slice, shape (n q, 8). Quadratic ones span two
            slices and have three levels of nine nodes, shape (n q / 2, 27).
        core: truss edges between neighbouring axis nodes, shape (n, 2).
        lengths: of the slices in mm, shape (n,).
        section: the unit cross-section.
        radius: physical radius of the rod in mm.
        node_scale: distance of the boundary nodes from the axis over `radius`.
    """

    nodes: FloatArray
    hexes: IntArray
    core: IntArray
    lengths: FloatArray
    section: Section
    radius: float
    node_scale: float

    @property
    def length(self) -> float:
        """Length in mm."""
        return float(self.nodes[-1, 2] - self.nodes[0, 2])

    @property
    def slices(self) -> int:
        """Number of slices n."""
        return self.lengths.size

    @property
    def element_length(self) -> float:
        """Mean length of a slice in mm."""
        return self.length / self.slices

    @property
    def heights(self) -> FloatArray:
        """Lengths of the layers of hexahedra over their mean, shape (n / span,)."""
        return self.lengths[:: self.span] / self.element_length

    @property
    def span(self) -> int:
        """Slices that a hexahedron spans."""
        return self.section.order

    @property
    def layers(self) -> IntArray:
        """Nodes of each hexahedron, layer after layer, shape (n / span, q, 8 or 27)."""
        return self.hexes.reshape(self.slices // self.span, len(self.section.quads), -1)

    @property
    def cells(self) -> IntArray:
        """Hexahedra in the order of VTK, shape (E, 8) or (E, 27)."""
        return self.hexes if self.span == 1 else self.hexes[:, _VTK_27]

    @property
    def bricks(self) -> IntArray:
        """The hexahedra, or the eight that each quadratic one is cut into, in VTK order, shape (E, 8)."""
        if self.span == 1:
            return self.hexes
        return self.hexes[:, _CUT].reshape(-1, 8)

    @property
    def faces(self) -> IntArray:
        """Quadrilaterals of the section, or the four that each of nine nodes is cut into, shape (q, 4)."""
        quads = self.section.quads
        return quads if self.span == 1 else quads[:, _CUT_QUAD].reshape(-1, 4)

    @property
    def section_nodes(self) -> IntArray:
        """Nodes of each section, shape (n + 1, m)."""
        return np.arange(len(self.nodes)).reshape(self.slices + 1, -1)

    @property
    def ring_nodes(self) -> IntArray:
        """Boundary nodes of each section, counter-clockwise from the direction d1, shape (n + 1, k)."""
        return self.section_nodes[:, self.section.ring]

    @property
    def axis_nodes(self) -> IntArray:
        """Nodes on the centreline, shape (n + 1,)."""
        return self.section_nodes[:, self.section.axis]

    @property
    def surface(self) -> IntArray:
        """Quadrilaterals of the whole boundary, normals outwards: side, first end, last end, shape (n k + 2 q, 4)."""
        last = self.faces + self.section_nodes[-1, 0]
        return np.concatenate([side_quads(self.ring_nodes), self.faces[:, ::-1], last])


def side_quads(rings: IntArray) -> IntArray:
    """Quadrilaterals between successive rings of nodes, normals outwards.

    Args:
        rings: counter-clockwise about the direction in which they follow, shape (n + 1, k).

    Returns:
        Shape (n k, 4).
    """
    ahead = np.roll(rings, -1, axis=1)
    return np.stack([rings[:-1], ahead[:-1], ahead[1:], rings[1:]], axis=-1).reshape(-1, 4)


def extrude(
    section: Section, radius: float, length: float, slices: int | Slices, *, match_bending: bool = True
) -> RodMesh:
    """Extrude a cross-section into a straight rod.

    Args:
        section: the unit cross-section; its x and y become the directions d1 and d2.
        radius: radius of the rod in mm.
        length: length of the rod in mm.
        slices: number of slices of equal length, or the slices themselves, which fill the length; of nine-node
            quadrilaterals the two of each element, which are of one length.
        match_bending: move the boundary nodes outwards until the facetted section's second moment is the circle's
            pi r^4 / 4; otherwise the nodes lie on the circle itself.

    Raises:
        InputError: radius or length is not positive and finite, or there are no slices.
    """
    for key, value in (("radius", radius), ("length", length)):
        if not (isfinite(value) and value > 0):
            raise InputError(
                f"the {key} of a rod is positive and finite", key=key, found=value, expected="a length in mm"
            )
    n = slices if isinstance(slices, int) else slices.count
    if n < 1:
        raise InputError("a rod has at least one slice", key="slices", found=n, expected="a positive whole number")
    if n % section.order:
        raise InputError("quadratic elements span two slices each", key="slices", found=n, expected="an even number")
    made = equal_slices(length, n) if isinstance(slices, int) else slices
    m, span = len(section.points), section.order
    node_scale = scale_for_bending(section) if match_bending else 1.0
    nodes = np.empty((n + 1, m, 3))
    nodes[:, :, :2] = radius * node_scale * section.points
    nodes[:, :, 2] = made.arclength[:, None]
    nodes[-1, :, 2] = length
    bottom = m * np.arange(0, n, span)[:, None, None] + section.quads
    levels = [bottom + level * m for level in range(span + 1)]
    hexes = np.concatenate(levels, axis=-1)
    hexes = hexes.reshape(-1, hexes.shape[-1])
    start = section.axis + m * np.arange(n)
    core = np.column_stack([start, start + m])
    return RodMesh(nodes.reshape(-1, 3), hexes, core, made.lengths, section, float(radius), node_scale)
