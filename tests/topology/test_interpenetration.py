import time
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.clearance import strand_clearance
from knotfem.topology.interpenetration import first_interpenetration

Array = NDArray[np.float64]


def straight(direction: int, height: float, nodes: int = 41) -> Array:
    x = np.zeros((nodes, 3))
    x[:, direction] = np.linspace(-20.0, 20.0, nodes)
    x[:, 2] = height
    return x


def test_crossed_rods_that_swap_interpenetrate() -> None:
    still, over = straight(0, 0.0), straight(1, 1.5)
    below = over - [0, 0, 2.0]
    found = first_interpenetration([still, over], [still, below], 1.0)
    assert found is not None
    assert found.rods == (0, 1)
    assert found.edges[0] in (19, 20)
    assert 0.725 <= found.time <= 0.75


def test_parallel_rods_that_swap_in_their_plane_interpenetrate() -> None:
    a, b = straight(0, 0.0), straight(0, 1.0)
    assert first_interpenetration([a, b], [b, a], 1.0) is not None


def test_sliding_touching_and_passing_the_end_are_legal() -> None:
    still, over = straight(0, 0.0), straight(1, 1.0)
    assert first_interpenetration([still, over], [still, over + np.array([3.0, 1.0, 0.0])], 1.0) is None
    beyond = over + np.array([25.0, 0, 0])
    assert first_interpenetration([still, beyond], [still, beyond - [0, 0, 2.0]], 1.0) is None


@pytest.mark.parametrize(("height", "reported"), [(0.04, True), (0.06, False)])
def test_centrelines_closer_than_a_twentieth_of_a_diameter_count_as_crossing(
    rigid: Callable[[int], tuple[Array, Array]], height: float, reported: bool
) -> None:
    rotation, _ = rigid(3)
    still, over = straight(0, 0.0) @ rotation.T, straight(1, height) @ rotation.T
    found = first_interpenetration([still, over], [still, over + rotation @ np.array([1.0, 0.0, 0.0])], 1.0)
    assert (found is not None) == reported


def test_orbit_by_a_diameter_each_is_legal() -> None:
    for angle in (0.3, 1.0, 2.0, 2.8):
        a = np.column_stack([np.linspace(-5, 5, 21), np.zeros(21), np.full(21, 0.5)])
        c, s = np.cos(angle), np.sin(angle)
        rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        assert first_interpenetration([a, -a], [a @ rotation.T, -a @ rotation.T], 1.0) is None


def test_strand_of_the_same_rod(shipped: Callable[[str], Array]) -> None:
    x = shipped("overhand")
    closest = strand_clearance(x, 1.0)
    towards = x[closest.j] - x[closest.i]
    weight = np.exp(-(((np.arange(len(x)) - closest.i) / 12.0) ** 2))[:, None]
    assert first_interpenetration(x, x + 0.5 * weight * towards, 1.0) is None
    found = first_interpenetration(x, x + 1.8 * weight * towards, 1.0)
    assert found is not None
    assert found.rods == (0, 0)
    assert abs(found.edges[0] - closest.i) < 15
    assert abs(found.edges[1] - closest.j) < 15
    assert first_interpenetration(x + 1.8 * weight * towards, x, 1.0) is not None


def test_pulling_a_bight_through_counts_although_the_writhe_is_the_same() -> None:
    post = straight(1, 0.0)
    bight = np.column_stack([-(np.linspace(-8, 8, 33) ** 2) / 8 - 1, np.linspace(-8, 8, 33), np.zeros(33)])[
        :, [0, 2, 1]
    ]
    assert first_interpenetration([post, bight], [post, bight + np.array([2.5, 0.0, 0.0])], 1.0) is not None


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 0.7))
def test_motion_shorter_than_the_clearance_is_legal(
    shipped: Callable[[str], Array], random_curve: Callable[..., Array], seed: int, size: float
) -> None:
    x = shipped("granny")
    push = random_curve(seed, 6, len(x))
    push *= size / np.linalg.norm(push, axis=1).max()
    assert strand_clearance(x + push, 1.0).distance > 0.2
    assert first_interpenetration(x, x + push, 1.0) is None


def test_refuses_other_nodes() -> None:
    with pytest.raises(InputError, match="differ in their nodes"):
        first_interpenetration(straight(0, 0.0), straight(0, 0.0)[:-1], 1.0)


def test_is_fast(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    y = x + [3.0, 0.0, 2.0] * np.sin(np.linspace(0, 6, len(x)))[:, None]
    first_interpenetration(x, y, 6.0)
    begin = time.perf_counter()
    first_interpenetration(x, y, 6.0)
    assert time.perf_counter() - begin < 0.05
