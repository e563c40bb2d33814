from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.topology.diagram import Diagram, crossing_signature, diagram, view_frame

Array = NDArray[np.float64]
BOWLINE = "O1- U2- U3+ O4- O5+ U6+ U7- O3+ U5+ O6+ U1- O2- O7- U4-"


def test_bowline_from_the_front(shipped: Callable[[str], Array]) -> None:
    assert crossing_signature(shipped("bowline"), (0, -1, 0)) == BOWLINE
    assert crossing_signature(shipped("bowline")) == BOWLINE


def test_from_behind_over_becomes_under(shipped: Callable[[str], Array]) -> None:
    swapped = BOWLINE.translate(str.maketrans("OU", "UO"))
    assert crossing_signature(shipped("bowline"), (0, 1, 0)) == swapped


def test_mirror_turns_the_signs(shipped: Callable[[str], Array]) -> None:
    mirrored = shipped("bowline") * [-1, 1, 1]
    assert crossing_signature(mirrored) == BOWLINE.translate(str.maketrans("+-", "-+"))


def test_signature_does_not_care_how_fine_the_polyline_is(shipped: Callable[[str], Array]) -> None:
    assert crossing_signature(shipped("bowline")[::3]) == BOWLINE


@pytest.mark.parametrize(("height", "expected"), [(1.0, "U1+ O1+"), (-1.0, "O1- U1-")])
def test_single_crossing(height: float, expected: str) -> None:
    # Seen from above: first along +x, round to the left, then back across it downwards.
    loop = np.array([[-3.0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, height], [0, -3, height]])
    assert crossing_signature(loop, (0, 0, 1)) == expected


def test_straight_rod_has_none() -> None:
    assert crossing_signature([[0, 0, 0], [1, 0, 0], [2, 0, 0]]) == ""


def test_view_frame_is_right_handed_and_upright() -> None:
    front = view_frame((0, -1, 0))
    assert front == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))
    for view in ((0, 0, 1), (0, 0, -1), (1, 2, 3)):
        frame = view_frame(view)
        assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        assert frame[2] == pytest.approx(np.array(view) / np.linalg.norm(view))


def test_planar_code_of_the_trefoil(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    found = diagram(closed_braid([1, 1, 1]), (0.01, 0.02, 1))
    assert found.signs == (1, 1, 1)
    assert found.writhe == 3
    assert sorted(arc for crossing in found.crossings for arc in crossing) == sorted([1, 2, 3, 4, 5, 6] * 2)
    for under_in, right, under_out, left in found.crossings:
        assert under_out == under_in % 6 + 1
        assert right == left % 6 + 1
    assert str(found).startswith("PD[X[")


def test_rings_apart_are_loops() -> None:
    ring = np.array([[1.0, 0, 0], [0, 1, 0.1], [-1, 0, 0], [0, -1, -0.1]])
    assert diagram([ring, ring + np.array([5, 0, 0])], (0.1, 0.1, 1)) == Diagram((), (), 2)


def test_many_crossings_are_all_found() -> None:
    a = np.linspace(0.0, 2 * np.pi, 3000, endpoint=False)
    lissajous = np.column_stack([np.cos(11 * a + 0.3), np.cos(13 * a), np.cos(17 * a + 0.7)])
    assert len(diagram([lissajous], (0, 0, 1)).crossings) == 2 * 11 * 13 - 11 - 13
