"""Knot types by several ways of closing a curve."""

from __future__ import annotations

import numpy as np
import pytest

from knotfem.topology import closures
from knotfem.topology.closures import (
    Closures,
    check_smoothing,
    closures_of,
    is_knotted,
    name_of,
    random_directions,
    ways_of,
)
from knotfem.topology.knot_type import KnotType, knot_type

TANGENT = (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
OUTWARD = (np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))


def trefoil(part: float) -> np.ndarray:
    a = np.linspace(0.0, 2.0 * np.pi * part, 200)
    r = 2.0 + np.cos(3.0 * a)
    return np.column_stack([r * np.cos(2.0 * a), r * np.sin(2.0 * a), np.sin(3.0 * a)])


def test_random_directions_are_always_the_same_and_everywhere() -> None:
    d = np.array(random_directions())
    assert np.linalg.norm(d, axis=1) == pytest.approx(1.0)
    assert np.array_equal(d, np.array(random_directions.__wrapped__()))
    assert np.abs(d.mean(axis=0)).max() < 0.5
    assert len(ways_of(TANGENT, OUTWARD)) == 12


def test_closures_that_agree_are_called_by_the_name_alone() -> None:
    long = np.concatenate([[[0.0, 0.0, 40.0]], trefoil(0.97), [[0.0, 40.0, 0.0]]])
    found = closures_of(long, ways_of(TANGENT, OUTWARD))
    assert (str(found), found.counts) == ("3_1", {"3_1": 12})


def test_closures_that_disagree_say_so() -> None:
    tied, other = knot_type(trefoil(0.97)), knot_type(trefoil(0.2))
    assert str(Closures((other, *(tied,) * 11))) == "3_1 (by 11 of 12 closures; unknot by 1, unknot along its tangents)"
    said = str(Closures((tied, other, tied)))
    assert said == "3_1 (by 2 of 3 closures; unknot by 1)"
    assert [name_of(text) for text in (said, str(Closures((tied,))), "hitch")] == ["3_1", "3_1", "hitch"]
    assert Closures((other, tied)).most == other
    mirror = KnotType(tied.name, "left", tied.jones.mirror, 3)
    assert str(Closures((tied, tied, mirror))) == "3_1 (by 2 of 3 closures; 3_1 by 1)"


@pytest.mark.parametrize(
    ("untied", "held", "computed"),
    [(set(), True, 2), ({0}, True, 12), ({0, 1}, True, 12), (set(range(6)), True, 12), (set(range(7)), False, 12)],
)
def test_most_closures_decide_whether_a_curve_is_knotted(
    monkeypatch, untied: set[int], held: bool, computed: int
) -> None:
    """Two that agree on a knot are enough, so that a knot which holds costs two closures."""
    ways, asked = ways_of(TANGENT, OUTWARD), list[object]()

    def typed(points: np.ndarray, way: object) -> KnotType:
        asked.append(way)
        return knot_type(trefoil(0.2 if any(way is ways[i] for i in untied) else 0.97))

    monkeypatch.setattr(closures, "knot_type", typed)
    assert is_knotted(trefoil(0.97), ways) == held
    assert len(asked) == computed


def test_ends_of_measured_points_that_point_anywhere_change_no_knot() -> None:
    """The last edge of the points runs through the knot, that of the smoothed curve does not."""
    smooth = np.concatenate([[[0.0, 0.0, 40.0]], trefoil(0.93), [[0.0, 40.0, 0.0]]])
    measured = smooth.copy()
    inward = trefoil(0.93).mean(axis=0) - smooth[-2]
    measured[-1] = smooth[-2] + 0.3 * inward / np.linalg.norm(inward)
    assert knot_type(measured).name != knot_type(smooth).name
    check_smoothing(measured, smooth)
