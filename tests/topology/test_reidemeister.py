from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.topology.diagram import Diagram, diagram
from knotfem.topology.jones import jones
from knotfem.topology.reidemeister import reduce

Array = NDArray[np.float64]
ABOVE = (0.01, 0.02, 1.0)


def test_one_curl_leaves_a_loop() -> None:
    assert reduce(Diagram(((1, 1, 2, 2),), (1,))) == Diagram((), (), 1)


@pytest.mark.parametrize(
    ("word", "crossings", "loops"),
    [
        ([1, -1], 0, 2),
        ([1, 1, -1], 0, 1),
        ([1, 1, 1], 3, 0),
        ([1, 2], 0, 1),
        ([1, 1, 1, 2, -2, 2], 3, 0),
        ([1, 2, -2, -1], 0, 3),
        ([1, 1, 3, 3], 4, 0),
        ([1, 1, 1, 3, -3], 3, 2),
    ],
)
def test_braids(closed_braid: Callable[[list[int]], list[Array]], word: list[int], crossings: int, loops: int) -> None:
    found = reduce(diagram(closed_braid(word), ABOVE))
    assert (len(found.crossings), found.loops) == (crossings, loops)


def test_alternating_pairs_are_not_pulled_apart(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    whole = diagram(closed_braid([1, -2, 1, -2]), ABOVE)
    assert reduce(whole) == whole


def test_signs_stay_with_their_crossings(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    found = reduce(diagram(closed_braid([1, -2, 1, -2, 3]), ABOVE))
    assert sorted(found.signs) == [-1, -1, 1, 1]


def test_random_projections_keep_their_polynomial(random_curve: Callable[..., Array]) -> None:
    shrunk = 0
    for seed in range(12):
        whole = diagram([random_curve(seed, 7, 121)], ABOVE)
        found = reduce(whole)
        assert jones(found) == jones(whole)
        shrunk += len(whole.crossings) - len(found.crossings)
    assert shrunk > 30
