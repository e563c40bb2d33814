import time
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.smoothing import laplacian
from knotfem.topology.closures import check_smoothing
from knotfem.topology.knot_table import PRIME, names
from knotfem.topology.knot_type import knot_type

Array = NDArray[np.float64]
Braid = Callable[[list[int]], list[Array]]

SHIPPED = {
    "bowline_arcs": ("8_20, left-handed", "-t^-5 + t^-4 - t^-3 + 2t^-2 - t^-1 + 2 - t"),
    "overhand": ("3_1, right-handed", "t + t^3 - t^4"),
    "figure_eight": ("4_1", "t^-2 - t^-1 + 1 - t + t^2"),
    "double_overhand": ("5_1, right-handed", "t^2 + t^4 - t^5 + t^6 - t^7"),
    "cinquefoil": ("5_1, right-handed", "t^2 + t^4 - t^5 + t^6 - t^7"),
    "granny": ("3_1 # 3_1, right-handed", "t^2 + 2t^4 - 2t^5 + t^6 - 2t^7 + t^8"),
    "square": ("3_1 # mirror 3_1", "-t^-3 + t^-2 - t^-1 + 3 - t + t^2 - t^3"),
    "surgeon": ("5_1 # mirror 3_1, right-handed", "-t^-2 + t^-1 - 1 + 3t - 2t^2 + 3t^3 - 2t^4 + t^5 - t^6"),
    "two_half_hitches": ("3_1 # 3_1, left-handed", "t^-8 - 2t^-7 + t^-6 - 2t^-5 + 2t^-4 + t^-2"),
    "round_turn_two_half_hitches": ("3_1 # 3_1, left-handed", "t^-8 - 2t^-7 + t^-6 - 2t^-5 + 2t^-4 + t^-2"),
    "alpine_butterfly": ("unknot", "1"),
    "clove_hitch": ("unknot", "1"),
    "capstan_half": ("unknot", "1"),
    "capstan": ("unknot", "1"),
    "capstan_3": ("unknot", "1"),
}

BRAIDS = {
    "3_1": [1, 1, 1],
    "4_1": [1, -2, 1, -2],
    "5_1": [1] * 5,
    "5_2": [1, 1, 1, 2, -1, 2],
    "6_1": [1, 1, 2, -1, -3, 2, -3],
    "6_2": [1, 1, 1, -2, 1, -2],
    "6_3": [1, 1, -2, 1, -2, -2],
    "7_1": [1] * 7,
    "7_2": [1, 1, 1, 2, -1, 2, 3, -2, 3],
    "7_3": [1, 1, 1, 1, 1, 2, -1, 2],
    "7_4": [1, 1, 2, -1, 2, 2, 3, -2, 3],
    "7_5": [1, 1, 1, 1, 2, -1, 2, 2],
    "7_6": [1, 1, -2, 1, 3, -2, 3],
    "7_7": [1, -2, 1, -2, 3, -2, 3],
    "8_19": [1, 1, 1, 2, 1, 1, 1, 2],
    "8_20": [1, 1, 1, -2, -1, -1, -1, -2],
    "8_21": [1, 1, 1, 2, -1, -1, 2, 2],
}
DETERMINANTS = (3, 5, 5, 7, 9, 11, 13, 7, 11, 13, 15, 17, 19, 21, 3, 9, 15)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_curves(shipped: Callable[[str], Array], name: str) -> None:
    found = knot_type(shipped(name))
    assert (str(found), str(found.jones)) == SHIPPED[name]


@pytest.mark.parametrize(
    ("name", "crossings"), [("overhand", 3), ("figure_eight", 4), ("cinquefoil", 5), ("granny", 6), ("square", 6)]
)
def test_few_crossings_are_left(shipped: Callable[[str], Array], name: str, crossings: int) -> None:
    assert knot_type(shipped(name)).crossings == crossings


@pytest.mark.parametrize(
    ("tail", "name", "polynomial"),
    [
        ("tangent", "8_20", "-t^-5 + t^-4 - t^-3 + 2t^-2 - t^-1 + 2 - t"),
        ((0, 1, 0), "8_20", "-t^-5 + t^-4 - t^-3 + 2t^-2 - t^-1 + 2 - t"),
        ((0, -1, 0), "6_3", "-t^-3 + 2t^-2 - 2t^-1 + 3 - 2t + 2t^2 - t^3"),
    ],
)
def test_bowline_depends_on_its_tail(
    shipped: Callable[[str], Array], tail: str | tuple[int, int, int], name: str, polynomial: str
) -> None:
    found = knot_type(shipped("bowline"), ("tangent", tail))
    assert (found.name, str(found.jones)) == (name, polynomial)


def test_halves_of_the_butterfly(shipped: Callable[[str], Array]) -> None:
    x = shipped("alpine_butterfly")
    eye = int(np.argmin(x[:, 1]))
    assert str(knot_type(x[:eye])) == "3_1, right-handed"
    assert str(knot_type(x[eye:])) == "3_1, left-handed"


@pytest.mark.parametrize("name", BRAIDS)
def test_table_against_braids(closed_braid: Braid, name: str) -> None:
    (polygon,) = closed_braid(BRAIDS[name])
    found = knot_type(polygon, closed=True)
    assert found.name == name
    assert found.crossings >= int(name[0])
    value = sum(c * (-1) ** (e // 2) for e, c in found.jones.terms)
    assert abs(value) == DETERMINANTS[list(BRAIDS).index(name)]
    mirrored = knot_type(polygon * [1, 1, -1], closed=True)
    assert mirrored.name == name
    assert {found.handedness, mirrored.handedness} == ({""} if name in ("4_1", "6_3") else {"left", "right"})


def test_table_has_every_knot_once_and_its_mirror() -> None:
    assert set(BRAIDS) == set(PRIME)
    table = names()
    assert all(table[polynomial.mirror][0] == name for polynomial, (name, _) in table.items())
    hands = list(table.values())
    assert len(hands) == len(set(hands))
    assert {name for name, _ in hands} >= {"unknot", "3_1 # 3_1 # mirror 3_1", "5_2 # mirror 3_1", "4_1 # 4_1"}


def test_unknown_knot_is_not_guessed(closed_braid: Braid) -> None:
    (polygon,) = closed_braid([1] * 11)
    found = knot_type(polygon, closed=True)
    assert found.name == "unnamed"
    assert found.handedness == ""
    assert str(found) == f"unnamed ({found.jones})"
    assert found.crossings == 11


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(4, 14))
def test_type_is_that_of_the_shape(
    random_curve: Callable[..., Array], rigid: Callable[[int], tuple[Array, Array]], seed: int, modes: int
) -> None:
    x, (rotation, shift) = random_curve(seed, modes), rigid(seed)
    found = knot_type(x).jones
    assert knot_type(50.0 * x @ rotation.T + 30.0 * shift).jones == found
    assert knot_type(x[::-1]).jones == found
    assert knot_type(x * [1, -1, 1]).jones == found.mirror
    assert sum(c for _, c in found.terms) == 1


def test_straight_rod_is_unknotted() -> None:
    assert knot_type(np.outer(np.arange(30.0), [1, 0, 0])).name == "unknot"


def test_refuses() -> None:
    with pytest.raises(InputError, match="not finite"):
        knot_type([[0, 0, 0], [1, 0, 0], [np.nan, 0, 0]])
    with pytest.raises(InputError, match="at least 3"):
        knot_type([[0, 0, 0], [1, 0, 0]], closed=True)


def test_smoothing_away_the_knot_is_refused(shipped: Callable[[str], Array]) -> None:
    x = shipped("overhand")
    check_smoothing(x, laplacian(x, 0.1, 1000))
    message = r"knot\.csv: smoothing has changed the knot; take fewer iterations; found unknot; expected 3_1"
    with pytest.raises(InputError, match=message):
        check_smoothing(x, laplacian(x, 1.0, 60_000), "knot.csv")


def test_is_fast(shipped: Callable[[str], Array]) -> None:
    x = shipped("surgeon")
    knot_type(x)
    begin = time.perf_counter()
    knot_type(x)
    assert time.perf_counter() - begin < 0.2
