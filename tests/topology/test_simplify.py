from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from knotfem.topology.closure import close
from knotfem.topology.diagram import diagram
from knotfem.topology.jones import jones
from knotfem.topology.reidemeister import reduce
from knotfem.topology.simplify import simplify

Array = NDArray[np.float64]


def test_unknot_becomes_a_triangle() -> None:
    a = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    flat = np.column_stack([np.cos(a), np.sin(a), 0.0 * a])
    (left,) = simplify([flat])
    assert left.shape == (3, 3)


def test_tangled_unknot_becomes_a_triangle(shipped: Callable[[str], Array]) -> None:
    (left,) = simplify([close(shipped("capstan_3"))])
    assert len(left) == 3


def test_knot_keeps_its_polynomial_with_few_vertices(shipped: Callable[[str], Array]) -> None:
    whole = close(shipped("figure_eight"))
    (left,) = simplify([whole])
    assert len(left) < 20
    assert jones(reduce(diagram([left]))) == jones(reduce(diagram([whole])))


def test_vertices_hardly_move(shipped: Callable[[str], Array]) -> None:
    whole = close(shipped("figure_eight"))
    (left,) = simplify([whole])
    moved = np.linalg.norm(whole[None] - left[:, None], axis=2).min(axis=1)
    assert moved.max() < 1e-6 * np.ptp(whole, axis=0).max()


def test_linked_rings_stay_linked(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    left = simplify(closed_braid([1, 1]))
    assert [len(polygon) for polygon in left] == [3, 3]
    assert abs(reduce(diagram(left)).writhe) == 2
    apart = simplify(closed_braid([1, -1]))
    assert reduce(diagram(apart)).crossings == ()
