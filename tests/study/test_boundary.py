"""Bisection of the friction from which on a knot holds."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem.study.stability.boundary import Bracket, bracket_of, next_friction


def bisected(holds, limits=(0.0, 0.4), width=0.01, first: Sequence[float] = ()) -> dict[float, bool]:
    known: dict[float, bool] = {friction: holds(friction) for friction in first}
    for _ in range(40):
        friction = next_friction(known, frozenset(known), limits, width)
        if friction is None:
            return known
        assert limits[0] <= friction <= limits[1]
        known[friction] = holds(friction)
    raise AssertionError("no end")


@given(st.floats(0.001, 0.399), st.sampled_from([0.01, 0.02, 0.003]))
def test_any_threshold_is_found_to_the_width(threshold, width):
    known = bisected(lambda friction: friction >= threshold, width=width)
    found = bracket_of(known)
    assert found is not None
    assert found.low < threshold <= found.high
    assert found.high - found.low <= width * 1.001
    assert found.monotone
    assert len(known) <= 12


def test_points_of_a_grid_are_used():
    known = bisected(lambda friction: friction >= 0.137, first=[0.05 * i for i in range(9)])
    assert len(known) - 9 <= 3
    found = bracket_of(known)
    assert found is not None
    assert (found.low, found.high, found.monotone) == (pytest.approx(0.13), pytest.approx(0.14), True)


@pytest.mark.parametrize("always", [True, False])
def test_a_knot_that_always_or_never_holds_has_no_boundary(always):
    known = bisected(lambda friction: always)
    assert len(known) == (2 if always else 1)
    assert bracket_of(known) is None


def test_where_it_holds_at_a_smaller_friction_too_the_upper_change_counts_and_is_told():
    found = bracket_of({0.0: False, 0.1: True, 0.15: False, 0.2: True, 0.3: True})
    assert found is not None
    assert found == Bracket(0.15, 0.2, False)
    assert found.middle == pytest.approx(0.175)


def test_a_friction_without_verdict_is_not_tried_again():
    assert next_friction({0.0: False, 0.4: True}, frozenset({0.0, 0.4, 0.2}), (0.0, 0.4), 0.01) is None
