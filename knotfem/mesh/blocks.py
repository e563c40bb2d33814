"""The gmsh model of a cross-section: transfinite blocks, recombined into quadrilaterals."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import MissingDependency
from knotfem.mesh.layout import Layout

Corner = tuple[float, float]

_OPTIONS = {"General.Terminal": 0, "Mesh.ElementOrder": 1, "Mesh.SubdivisionAlgorithm": 0, "Mesh.MeshOnlyVisible": 0}
"""Options of gmsh that the mesh depends on; those of the program around are put back afterwards."""
_TIGHT = 1e-6


def mesh_blocks(layout: Layout) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Mesh the unit disc block by block in gmsh.

    Nothing is printed, no signal handler is set, and a program around that uses gmsh finds its models, the current one
    and its options as they were.

    Args:
        layout: core block and rings.

    Returns:
        Node positions, shape (m, 2), and quadrilaterals, shape (q, 4).

    Raises:
        MissingDependency: gmsh or a system library that it loads is absent.
    """
    with _gmsh() as gmsh:
        _Model(gmsh, layout).build()
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, quads = gmsh.model.mesh.getElementsByType(gmsh.model.mesh.getElementType("quadrangle", 1))
    order = np.argsort(tags)
    points = np.asarray(coordinates, dtype=np.float64).reshape(-1, 3)[order, :2]
    outer = np.hypot(*points.T) > 1 - _TIGHT
    step = 2 * pi / (4 * layout.across)
    angle = step * np.round(np.arctan2(points[outer, 1], points[outer, 0]) / step)
    points[outer] = np.column_stack([np.cos(angle), np.sin(angle)])
    return points, np.searchsorted(tags[order], np.asarray(quads)).reshape(-1, 4).astype(np.int64)


@contextmanager
def _gmsh() -> Iterator[Any]:
    """gmsh with an empty model of our own.

    Raises:
        MissingDependency: it cannot be imported.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise MissingDependency(
            f"making a cross-section needs gmsh ({error}): pip install gmsh, and on Debian or Ubuntu "
            "apt-get install libgl1 libglu1-mesa libgomp1 libxrender1 libxcursor1 libxft2 libxinerama1; "
            "the shipped cross-sections need none of it"
        ) from error

    foreign = bool(gmsh.isInitialized())
    if not foreign:
        gmsh.initialize(interruptible=False, readConfigFiles=False)
    before = {name: gmsh.option.getNumber(name) for name in _OPTIONS}
    current = gmsh.model.getCurrent() if foreign else ""
    try:
        for name, value in _OPTIONS.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("knotfem section")
        try:
            yield gmsh
        finally:
            gmsh.model.remove()
    finally:
        if foreign:
            for name, value in before.items():
                gmsh.option.setNumber(name, value)
            if current in gmsh.model.list():
                gmsh.model.setCurrent(current)
        else:
            gmsh.finalize()


class _Model:
    """Quadrant by quadrant, the core in grid coordinates and one fan of blocks for the rings."""

    def __init__(self, gmsh: Any, layout: Layout) -> None:
        self.geo, self.layout, self.half = gmsh.model.geo, layout, layout.across // 2
        self.points: dict[Corner, int] = {}
        self.curves: dict[tuple[int, int], int] = {}
        self.centre = self._point((0.0, 0.0))

    def build(self) -> None:
        for quarter in range(4):
            self._core(quarter)
            if self.layout.rings:
                self._rings(quarter)
        self.geo.synchronize()

    def _core(self, quarter: int) -> None:
        half, inner = self.half, self.half - 1
        if self.layout.corners:
            self._block(quarter, [(0, 0), (half, 0), (half, half), (0, half)], half, half)
            return
        self._block(quarter, [(0, 0), (inner, 0), (inner, inner), (0, inner)], inner, inner)
        self._block(quarter, [(inner, 0), (half, 0), (half, inner), (inner, inner)], 1, inner)
        self._block(quarter, [(0, inner), (inner, inner), (inner, half), (0, half)], inner, 1)

    def _rings(self, quarter: int) -> None:
        """Blocks between the outline of the core and the circle, whose nodes share equal angles."""
        half, inner = self.half, self.half - 1
        if self.layout.corners:
            outline = [((half, 0), 0), ((half, half), half), ((0, half), 2 * half)]
        else:
            outline = [
                ((half, 0), 0),
                ((half, inner), inner),
                ((inner, inner), half),
                ((inner, half), half + 1),
                ((0, half), 2 * half),
            ]
        for (a, first), (b, last) in pairwise(outline):
            p, q = self._grid(quarter, *a), self._grid(quarter, *b)
            outer_p, outer_q = (self._circle(quarter * 2 * half + step) for step in (first, last))
            self._surface([p, outer_p, outer_q, q], self.layout.rings, last - first, arc=True)

    def _block(self, quarter: int, corners: list[tuple[int, int]], along: int, up: int) -> None:
        arc = not self.layout.rings
        tags = [self._grid(quarter, i, j) for i, j in corners]
        self._surface(tags, along, up, arc=arc and self.half in corners[2])

    def _surface(self, tags: list[int], along: int, up: int, *, arc: bool) -> None:
        """One transfinite block; its second side, and in a ringless section its third, is an arc of the circle."""
        a, b, c, d = tags
        outer_third = arc and not self.layout.rings
        loop = [
            self._curve(a, b, along),
            self._curve(b, c, up, arc=arc),
            self._curve(c, d, along, arc=outer_third),
            self._curve(d, a, up),
        ]
        surface = self.geo.addPlaneSurface([self.geo.addCurveLoop(loop)])
        self.geo.mesh.setTransfiniteSurface(surface, cornerTags=tags)
        self.geo.mesh.setRecombine(2, surface)

    def _grid(self, quarter: int, i: int, j: int) -> int:
        """Corner at step (i, j) of the core's quadrant: the square rounded towards a disc."""
        u, v = i / self.half, j / self.half
        size = self.half / (self.half + self.layout.rings)
        x, y = size * u * sqrt(1 - v * v / 2), size * v * sqrt(1 - u * u / 2)
        for _ in range(quarter):
            x, y = -y, x
        return self._point((x, y))

    def _circle(self, step: int) -> int:
        angle = 2 * pi * step / (4 * self.layout.across)
        return self._point((cos(angle), sin(angle)))

    def _point(self, corner: Corner) -> int:
        key = (round(corner[0], 9) + 0.0, round(corner[1], 9) + 0.0)
        if key not in self.points:
            self.points[key] = self.geo.addPoint(*corner, 0.0)
        return self.points[key]

    def _curve(self, a: int, b: int, steps: int, *, arc: bool = False) -> int:
        if (b, a) in self.curves:
            return -self.curves[b, a]
        if (a, b) not in self.curves:
            curve = self.geo.addCircleArc(a, self.centre, b) if arc else self.geo.addLine(a, b)
            self.geo.mesh.setTransfiniteCurve(curve, steps + 1)
            self.curves[a, b] = curve
        return self.curves[a, b]
