from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.geometry.frames import tangents
from knotfem.topology.linking import Ends, LinkType, link_type, linking_number, winding_angle, winding_range

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)


def outward(x: Array) -> Ends:
    t = tangents(x)
    return -t[0], t[-1]


def link(first: Array, second: Array) -> LinkType:
    return link_type((first, second), (outward(first), outward(second)))


def bight(axis: Array, across: Array, shift: float) -> Array:
    """A U of radius 10 in the plane of two axes, its legs 40 long, its top at `shift` along the first."""
    phi = np.linspace(0.0, np.pi, 25)
    arc = np.outer(shift - 10.0 + 10.0 * np.sin(phi), axis) + np.outer(10.0 * np.cos(phi), across)
    leg = np.linspace(40.0, 1.0, 20)[:, None] * axis
    return np.concatenate([arc[0] - leg, arc, arc[-1] - leg[::-1]])


@pytest.mark.parametrize("turn", [0.3, 1.2, 2.8])
@pytest.mark.parametrize("height", [-6.0, 6.0])
def test_rods_that_cross_or_run_side_by_side_are_not_linked(turn: float, height: float) -> None:
    s = np.linspace(-50.0, 50.0, 41)[:, None]
    assert not link(s * X, s * (np.cos(turn) * X + np.sin(turn) * Y) + height * Z).linked


def test_interlocked_bights_are_linked_until_one_is_drawn_out() -> None:
    def interlocked(depth: float) -> LinkType:
        return link(bight(X, Y, depth), bight(-X, Z, depth))

    assert interlocked(5.0).linked
    assert str(interlocked(5.0).jones) in ("-t^(1/2) - t^(5/2)", "-t^(-5/2) - t^(-1/2)")
    assert not interlocked(-5.0).linked


def test_the_sheet_bend_is_linked_and_its_rods_side_by_side_are_not(shipped: Callable[[str], Array]) -> None:
    hitch, loop = shipped("sheet_bend_hitch"), shipped("sheet_bend_bight")
    assert link(hitch, loop).linked
    assert link(loop, hitch).linked
    assert not link(hitch, loop + 150.0 * X).linked


def test_knots_of_the_rods_themselves_do_not_link_them(shipped: Callable[[str], Array]) -> None:
    trefoil, eight = shipped("overhand"), shipped("figure_eight")
    eight = eight - eight.mean(axis=0)
    beside = trefoil.mean(axis=0) + 80.0 * Y
    assert not link(trefoil, eight + beside).linked


def test_a_rod_about_a_straight_one_is_linked_from_one_turn_on() -> None:
    s = np.linspace(-1.0, 1.0, 201)

    def coil(turns: float) -> Array:
        phi = np.pi * turns * s
        return np.column_stack([40.0 * s, 8.0 * np.cos(phi), 8.0 * np.sin(phi)])

    straight = np.outer(60.0 * s, X)
    assert not link(coil(0.4), straight).linked
    assert link(coil(2.2), straight).linked


def test_winding_is_right_handed_about_the_axis() -> None:
    a = np.linspace(0.0, 7.0, 100)
    x = np.column_stack([5 + 2 * np.cos(a), 1 + 2 * np.sin(a), a])
    assert winding_angle(x, [5, 1, 0], [0, 0, 1]) == pytest.approx(7.0)
    assert winding_angle(x, [5, 1, 0], [0, 0, -3]) == pytest.approx(-7.0)
    assert winding_angle(x, [15, 1, 0], [0, 0, 1]) == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("bowline", -1),
        ("clove_hitch", 2),
        ("two_half_hitches", 1),
        ("round_turn_two_half_hitches", 2),
        ("capstan_half", 1),
        ("capstan", 2),
        ("capstan_3", 3),
    ],
)
def test_linking_numbers_of_shipped_curves(shipped: Callable[[str], Array], name: str, number: int) -> None:
    x = shipped(name)
    assert linking_number(x, [0, 0, 0], [0, 1, 0]) == number
    assert linking_number(x[::-1], [0, 0, 0], [0, 1, 0]) == -number
    assert linking_number(x * [1, 1, -1], [0, 0, 0], [0, 1, 0]) == -number


def test_the_range_of_winding_counts_turns_that_are_taken_back() -> None:
    """As those of a cow hitch; turns that go on count as the winding angle does."""

    def coil(*angles: float) -> Array:
        a = np.concatenate([np.linspace(p, q, 60)[1:] for p, q in pairwise(angles)])
        return np.asarray(np.column_stack([np.cos(a), np.sin(a), 0.01 * np.arange(len(a))]), dtype=np.float64)

    for turns in (0.3, -1.7):
        x = coil(0.0, 2.0 * np.pi * turns)
        assert winding_range(x, np.zeros(3), Z) == pytest.approx(abs(winding_angle(x, np.zeros(3), Z)))
    there_and_back = coil(0.0, 7.0, 0.0)
    assert linking_number(there_and_back, np.zeros(3), Z) == 0
    assert winding_range(there_and_back, np.zeros(3), Z) == pytest.approx(7.0, abs=0.15)
