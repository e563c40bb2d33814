"""Reference elements and quadrature of scikit-fem, in the numbering of this program.

scikit-fem's reference domains are [0, 1]^d and it numbers the nodes of a hexahedron and the points of a rule in an
order of its own. Here reference coordinates run from -1 to 1, a hexahedron's nodes are numbered level after level, the
nodes of a level being those of the quadrilateral, and points of integration run along x first, then y, then z; only
the 2 x 2 points of a quadrilateral stand in the order of its corners. Importing scikit-fem takes 0.3 s, so this is
done when an element is first asked for: a rod model needs none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from skfem.element import ElementH1

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ReferenceElement:
    """Shape functions on [-1, 1]^d.

    Attributes:
        element: of scikit-fem.
        nodes: reference coordinates of the nodes, shape (n, d).
        order: scikit-fem's number of each node, shape (n,).
    """

    element: ElementH1
    nodes: FloatArray
    order: IntArray

    def at(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Shape functions, shape (p, n), and their rates, shape (p, n, d), at points of shape (p, d)."""
        unit = 0.5 * (points.T + 1.0)
        values, rates = zip(*(self.element.lbasis(unit, int(i)) for i in self.order), strict=True)
        return np.stack(values, axis=1), 0.5 * np.stack([np.asarray(r).T for r in rates], axis=1)


@cache
def quadrilateral(order: int) -> ReferenceElement:
    """Four corners, counter-clockwise; of order 2 also the middles of the edges from each corner on, and the centre."""
    from skfem import ElementQuad1, ElementQuad2

    element = ElementQuad1() if order == 1 else ElementQuad2()
    flat = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0)]
    return _numbered(element, np.array(flat[: 4 if order == 1 else 9], dtype=np.float64))


@cache
def hexahedron(order: int) -> ReferenceElement:
    """Two levels of four nodes, or three of nine, from the lowest: see `quadrilateral`."""
    from skfem import ElementHex1, ElementHex2

    element = ElementHex1() if order == 1 else ElementHex2()
    flat = quadrilateral(order).nodes
    levels = np.linspace(-1.0, 1.0, order + 1)
    nodes = [np.column_stack([flat, np.full(len(flat), level)]) for level in levels]
    return _numbered(element, np.concatenate(nodes))


@cache
def gauss_line(count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points on [-1, 1], ascending, shape (count,), and their weights, which sum to 2."""
    if count == 1:  # scikit-fem has no rule of one point
        return _shared(np.zeros(1)), _shared(np.full(1, 2.0))
    from skfem.quadrature import get_quadrature
    from skfem.refdom import RefLine

    points, weights = get_quadrature(RefLine, 2 * count - 1)
    order = np.argsort(points[0])
    return _shared(2.0 * points[0][order] - 1.0), _shared(2.0 * weights[order])


@cache
def gauss_square(count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points on [-1, 1]^2, shape (count^2, 2), and their weights, which sum to 4."""
    from skfem.quadrature import get_quadrature
    from skfem.refdom import RefQuad

    points, weights = get_quadrature(RefQuad, 2 * count - 1)
    at = 2.0 * points.T - 1.0
    if count == 2:
        order = np.argmin(np.linalg.norm(quadrilateral(1).nodes[:, None] - at, axis=2), axis=1)
    else:
        order = np.lexsort((np.round(at[:, 0], 12), np.round(at[:, 1], 12)))
    return _shared(at[order]), _shared(4.0 * weights[order])


def _shared(values: FloatArray) -> FloatArray:
    """An array that nobody can change, for it is made once."""
    values.flags.writeable = False
    return values


def _numbered(element: ElementH1, nodes: FloatArray) -> ReferenceElement:
    places = 2.0 * np.asarray(element.doflocs, dtype=np.float64) - 1.0
    distance = np.linalg.norm(nodes[:, None] - places, axis=2)
    order = np.argmin(distance, axis=1)
    assert np.take_along_axis(distance, order[:, None], axis=1).max() == 0.0, "scikit-fem moved the nodes"
    return ReferenceElement(element, nodes, order.astype(np.int64))
