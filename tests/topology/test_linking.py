from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.geometry.frames import tangents
from knotfem.topology.linking import Ends, Lacing, lacing

Array = NDArray[np.float64]
X, Y, Z = np.eye(3)


def outward(x: Array) -> Ends:
    t = tangents(x)
    return -t[0], t[-1]


def laced(first: Array, second: Array) -> Lacing:
    return lacing((first, second), (outward(first), outward(second)))


def bight(axis: Array, across: Array, shift: float) -> Array:
    """A U of radius 10 in the plane of two axes, its legs 40 long, its top at `shift` along the first."""
    phi = np.linspace(0.0, np.pi, 25)
    arc = np.outer(shift - 10.0 + 10.0 * np.sin(phi), axis) + np.outer(10.0 * np.cos(phi), across)
    leg = np.linspace(40.0, 1.0, 20)[:, None] * axis
    return np.concatenate([arc[0] - leg, arc, arc[-1] - leg[::-1]])


@pytest.mark.parametrize("turn", [0.3, 1.2, 2.8])
@pytest.mark.parametrize("height", [-6.0, 6.0])
def test_rods_that_cross_or_run_side_by_side_are_not_laced(turn: float, height: float) -> None:
    s = np.linspace(-50.0, 50.0, 41)[:, None]
    assert not laced(s * X, s * (np.cos(turn) * X + np.sin(turn) * Y) + height * Z).laced


def test_a_clasp_is_laced_until_one_bight_is_drawn_out_of_the_other() -> None:
    def clasp(depth: float) -> Lacing:
        return laced(bight(X, Y, depth), bight(-X, Z, depth))

    assert clasp(5.0).laced
    assert str(clasp(5.0).jones) in ("-t^(1/2) - t^(5/2)", "-t^(-5/2) - t^(-1/2)")
    assert not clasp(-5.0).laced


def test_the_sheet_bend_is_laced_and_its_rods_side_by_side_are_not(shipped: Callable[[str], Array]) -> None:
    hitch, loop = shipped("sheet_bend_hitch"), shipped("sheet_bend_bight")
    assert laced(hitch, loop).laced
    assert laced(loop, hitch).laced
    assert not laced(hitch, loop + 150.0 * X).laced


def test_knots_of_the_rods_themselves_do_not_lace_them(shipped: Callable[[str], Array]) -> None:
    trefoil, eight = shipped("overhand"), shipped("figure_eight")
    eight = eight - eight.mean(axis=0)
    beside = trefoil.mean(axis=0) + 80.0 * Y
    assert not laced(trefoil, eight + beside).laced


def test_a_rod_round_a_straight_one_is_laced_from_one_turn_on() -> None:
    s = np.linspace(-1.0, 1.0, 201)

    def coil(turns: float) -> Array:
        phi = np.pi * turns * s
        return np.column_stack([40.0 * s, 8.0 * np.cos(phi), 8.0 * np.sin(phi)])

    straight = np.outer(60.0 * s, X)
    assert not laced(coil(0.4), straight).laced
    assert laced(coil(2.2), straight).laced
