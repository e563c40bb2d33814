"""Cross-section of a rod: quadrilaterals that fill a disc of unit radius."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_ON_CIRCLE = 1e-9


@dataclass(frozen=True, eq=False)
class Section:
    """Quadrilaterals that fill the regular polygon inscribed in the unit circle.

    Attributes:
        points: node positions in units of the node radius, shape (m, 2).
        quads: nodes of each quadrilateral, shape (q, 4): corners, counter-clockwise; or (q, 9): the corners, the
            middles of the edges from each corner to the next, and the centre.
        axis: the node at the origin.
        ring: boundary nodes, counter-clockwise at equal angles, the first at angle 0, shape (k,).
    """

    points: FloatArray
    quads: IntArray
    axis: int
    ring: IntArray

    @property
    def sides(self) -> int:
        """Number of nodes of the boundary."""
        return len(self.ring)

    @property
    def order(self) -> int:
        """Order of the quadrilaterals: 1 of four nodes, 2 of nine."""
        return 1 if self.quads.shape[1] == 4 else 2


@dataclass(frozen=True)
class Layout:
    """A core block of `across` x `across` quadrilaterals, with or without its four corners, inside rings of 4 `across`.

    Attributes:
        across: quadrilaterals along a side of the core block, even.
        corners: whether the block keeps its four corner quadrilaterals.
        rings: rings of quadrilaterals around the block.
    """

    across: int
    corners: bool
    rings: int

    @property
    def elements(self) -> int:
        """Number of quadrilaterals."""
        return self.across**2 - (0 if self.corners else 4) + 4 * self.across * self.rings


LAYOUTS: dict[int, Layout] = {
    layout.elements: layout
    for layout in (
        Layout(2, True, 0),
        Layout(2, True, 1),
        Layout(2, True, 2),
        Layout(4, False, 1),
        Layout(4, False, 2),
        Layout(4, True, 2),
        Layout(6, False, 2),
        Layout(6, False, 3),
        Layout(6, True, 3),
    )
}

available: tuple[int, ...] = tuple(sorted(LAYOUTS))


def make_section(elements: int) -> Section:
    """Mesh the unit disc with a chosen number of quadrilaterals (gmsh transfinite blocks, then smoothed).

    Args:
        elements: number of quadrilaterals, one of `available`; 44 is the paper's.

    Returns:
        The section, with the eight-fold mirror symmetry of the square.

    Raises:
        InputError: there is no layout with that many quadrilaterals.
        MissingDependency: gmsh or a system library that it loads is absent.
    """
    from knotfem.mesh.blocks import mesh_blocks
    from knotfem.mesh.smoothing import smooth

    layout = LAYOUTS.get(elements)
    if layout is None:
        raise InputError(
            "no cross-section with that many elements",
            key="section_elements",
            found=elements,
            expected="one of " + ", ".join(map(str, available)),
        )
    points, quads = mesh_blocks(layout)
    smoothed = smooth(_recognise(points, quads, file=None))
    return _recognise(smoothed.points, smoothed.quads, file=None)


def read_section(path: str | Path) -> Section:
    """Read a cross-section mesh and verify it.

    Args:
        path: Gmsh file (2.2, 4.0 or 4.1, text or binary) holding the quadrilaterals of a unit disc in the x-y plane.

    Raises:
        InputError: the file is missing or unreadable, or holds something else than a disc of unit radius meshed by
            quadrilaterals with a node at the origin and boundary nodes at equal angles, the first at angle 0.
    """
    import meshio

    path = Path(path)
    if not path.is_file():
        raise InputError("no such cross-section mesh", file=path)
    try:
        mesh = meshio.gmsh.read(path)
    except Exception as error:
        raise InputError(f"cannot be read as a Gmsh mesh ({str(error) or 'damaged'})", file=path) from error
    blocks = [block.data for block in mesh.cells if block.type == "quad"]
    if not blocks:
        found = ", ".join(sorted({block.type for block in mesh.cells})) or "no cells"
        raise InputError("a cross-section holds quadrilaterals", file=path, found=found, expected="quad cells")
    quads = np.concatenate(blocks).astype(np.int64)
    if quads.min() < 0 or quads.max() >= len(mesh.points):
        raise InputError("a quadrilateral names a node that is not there", file=path)
    if mesh.points.shape[1] > 2 and np.ptp(mesh.points[quads, 2]) > _ON_CIRCLE:
        raise InputError("a cross-section lies in the x-y plane", file=path)
    return _recognise(np.asarray(mesh.points[:, :2], dtype=float), quads, file=path)


def write_section(section: Section, path: str | Path) -> None:
    """Write a cross-section as Gmsh 2.2 text, with the physical groups `section`, `ring` and `axis`.

    Args:
        section: the cross-section.
        path: file to write; read back by `read_section`.
    """
    import meshio

    edges = np.column_stack([section.ring, np.roll(section.ring, -1)])
    points = np.column_stack([section.points, np.zeros(len(section.points))])
    cells = [("quad", section.quads), ("line", edges), ("vertex", np.array([[section.axis]]))]
    tags: list[ArrayLike] = [np.full(len(block), tag, dtype=np.int32) for tag, (_, block) in enumerate(cells, start=1)]
    names = {"section": np.array([1, 2]), "ring": np.array([2, 1]), "axis": np.array([3, 0])}
    mesh = meshio.Mesh(
        points,
        cells,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": list(tags)},
        field_data=names,
    )
    mesh.write(path, file_format="gmsh22", binary=False)


def area(section: Section) -> float:
    """Area of the unit section as its elements fill it (pi for the circle)."""
    if section.order == 2:
        from knotfem.mesh.quadratic import moments

        return moments(section)[0]
    x, y = section.points[section.ring].T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def second_moments(section: Section) -> tuple[float, float, float]:
    """Second moments of area (I_xx, I_yy, I_xy) = integrals of (y^2, x^2, x y) over the facetted unit section.

    The circle has pi/4, pi/4, 0.
    """
    if section.order == 2:
        from knotfem.mesh.quadratic import moments

        return moments(section)[1:]
    x0, y0 = section.points[section.ring].T
    x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
    cross = x0 * y1 - x1 * y0
    return (
        float(np.sum(cross * (y0 * y0 + y0 * y1 + y1 * y1)) / 12),
        float(np.sum(cross * (x0 * x0 + x0 * x1 + x1 * x1)) / 12),
        float(np.sum(cross * (x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0)) / 24),
    )


def scale_for_bending(section: Section) -> float:
    """Node radius over rod radius for which the facetted section has the circle's second moment pi r^4 / 4.

    Returns:
        The dimensionless factor, slightly above one: 1.0129 for 16 facets.
    """
    i_xx, i_yy, _ = second_moments(section)
    return float((np.pi / 4 / (0.5 * (i_xx + i_yy))) ** 0.25)


def _recognise(points: FloatArray, quads: IntArray, file: Path | None) -> Section:
    """Number the nodes from the axis outwards and check that they mesh the unit disc."""
    if not np.isfinite(points).all():
        raise InputError("node positions are not finite", file=file)
    used = np.unique(quads)
    points = points[used]
    radius, angle = np.hypot(*points.T), np.mod(np.arctan2(points[:, 1], points[:, 0]), 2 * np.pi)
    angle[(radius < _ON_CIRCLE) | (angle > 2 * np.pi - _ON_CIRCLE)] = 0.0
    order = np.lexsort((angle, np.round(radius, 9)))
    number = np.empty(used[-1] + 1, dtype=np.int64)
    number[used[order]] = np.arange(len(used))
    points, quads = points[order], number[quads]

    corners = points[quads]
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    signed = 0.5 * (diagonals[0][:, 0] * diagonals[1][:, 1] - diagonals[0][:, 1] * diagonals[1][:, 0])
    quads = np.where(signed[:, None] < 0, quads[:, ::-1], quads)
    edges = np.roll(points[quads], -1, axis=1) - points[quads]
    before = np.roll(edges, 1, axis=1)
    if (before[..., 0] * edges[..., 1] - before[..., 1] * edges[..., 0] <= 0).any():
        raise InputError("a quadrilateral is not convex", file=file)
    start = np.argmin(quads, axis=1)
    quads = np.take_along_axis(quads, (start[:, None] + np.arange(4)) % 4, axis=1)
    quads = quads[np.lexsort(quads.T[::-1])]

    if np.hypot(*points[0]) > _ON_CIRCLE:
        raise InputError("a cross-section has a node at the origin, on the rod's axis", file=file)
    ring = _boundary(points, quads, file)
    expected = 2 * np.pi * np.arange(len(ring)) / len(ring)
    circle = np.column_stack([np.cos(expected), np.sin(expected)])
    error = float(np.abs(points[ring] - circle).max())
    if error > _ON_CIRCLE:
        raise InputError(
            "boundary nodes lie on the unit circle at equal angles, the first at angle 0",
            file=file,
            found=f"a distance of {error:.3g} from there",
        )
    section = Section(points, quads, 0, ring)
    if abs(np.abs(signed).sum() - area(section)) > 1e-9:
        raise InputError("the quadrilaterals do not fill the disc once", file=file)
    return section


def _boundary(points: FloatArray, quads: IntArray, file: Path | None) -> IntArray:
    """Boundary nodes in counter-clockwise order, from the one furthest along x."""
    edges = np.column_stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()])
    directed = {(int(a), int(b)) for a, b in edges}
    following = {a: b for a, b in directed if (b, a) not in directed}
    first = max(following, key=lambda node: points[node, 0], default=0)
    ring = [first]
    while len(ring) <= len(following) and (node := following.get(ring[-1], first)) != first:
        ring.append(node)
    if len(directed) < len(edges) or len(ring) < 3 or len(ring) != len(following):
        raise InputError(
            "a cross-section has one closed boundary and each edge in at most two quadrilaterals", file=file
        )
    return np.array(ring, dtype=np.int64)
