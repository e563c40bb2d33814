"""Orders and limits of manufactured sequences, and sequences that have none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem.study.extrapolation import extrapolate, observed_order, pareto_front, rms

refinements = st.lists(st.floats(1.3, 3.0), min_size=2, max_size=4)


def sizes_of(ratios: list[float]) -> np.ndarray:
    return 1.7 / np.cumprod([1.0, *ratios])


@given(refinements, st.floats(0.6, 4.0), st.floats(-5.0, 5.0), st.floats(0.01, 10.0))
def test_order_and_limit_of_a_power(ratios, order, value, factor):
    h = sizes_of(ratios)
    curve = np.array([1.0, -2.0, 0.5])
    limit = extrapolate(h, value + factor * h[:, None] ** order * curve)
    assert limit.asymptotic
    assert limit.order == pytest.approx(order, rel=1e-6)
    assert limit.value == pytest.approx(np.full(3, value), abs=1e-7 * factor)


@given(st.floats(0.8, 3.0), st.floats(-0.15, 0.15))
def test_uncertainty_covers_what_a_higher_term_adds(order, higher):
    h = np.array([1.0, 0.5, 0.25, 0.125])
    values = 3.0 + (h**order + higher * h ** (order + 1.0))[:, None]
    three, four = extrapolate(h[1:], values[1:]), extrapolate(h, values)
    for limit in (three, four):
        assert abs(limit.value[0] - 3.0) <= limit.uncertainty
    assert three.uncertainty == pytest.approx(h[-1] ** order, rel=0.2)
    assert four.uncertainty < 0.5 * three.uncertainty


@given(refinements, st.floats(0.6, 4.0))
def test_limit_does_not_depend_on_the_unit_of_size(ratios, order):
    h = sizes_of(ratios)
    values = (2.0 + h**order + 0.01 * h ** (order + 1.0))[:, None]
    one, other = extrapolate(h, values), extrapolate(1e3 * h, values)
    assert one.behaviour == other.behaviour
    assert one.value == pytest.approx(other.value, rel=1e-6)


@pytest.mark.parametrize(
    ("values", "why", "uncertainty"),
    [
        ([1.0, 1.2, 1.1], "back and forth", 0.1),
        ([1.0, 1.2, 1.05], "back and forth", 0.2),
        ([1.0, 1.1, 1.3], "do not shrink", 0.3),
        ([1.0, 1.1, 1.2], "do not shrink", 0.2),
        ([2.0, 1.0001, 1.0], "order 13", 0.1),
        ([2.0, 1.0, 1.0], "equal", 0.1),
    ],
)
def test_sequences_without_an_order_are_said_to_have_none(values, why, uncertainty):
    limit = extrapolate(np.array([4.0, 2.0, 1.0]), np.array(values)[:, None])
    assert not limit.asymptotic
    assert why in limit.behaviour
    assert limit.value[0] == values[-1]
    assert limit.uncertainty == pytest.approx(uncertainty)


def test_limit_without_an_order_is_uncertain_by_what_first_order_leaves_of_the_last_change():
    limit = extrapolate(np.array([2.0, 1.0, 0.75]), np.array([[1.0], [2.0], [1.9]]))
    assert limit.uncertainty == pytest.approx(0.1 * 0.75 / 0.25)


def test_curves_that_change_in_unlike_ways_have_no_order():
    values = np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.2]])
    assert "back and forth" in extrapolate(np.array([4.0, 2.0, 1.0]), values).behaviour


def test_changes_below_the_floor_are_no_effect():
    values = 1.0 + 1e-7 * np.array([[1.0], [-1.0], [0.5]])
    limit = extrapolate(np.array([4.0, 2.0, 1.0]), values, floor=1e-6)
    assert (limit.behaviour, limit.order) == ("no effect", None)
    assert limit.uncertainty == pytest.approx(2e-7)


def test_fewer_than_three():
    one = extrapolate(np.array([1.0]), np.array([[2.0]]))
    two = extrapolate(np.array([2.0, 1.0]), np.array([[2.5], [2.0]]))
    assert one.uncertainty == np.inf
    assert (two.value[0], two.uncertainty, two.order) == (2.0, 1.5, None)


def test_sizes_must_fall():
    with pytest.raises(ValueError, match="fall"):
        extrapolate(np.array([1.0, 2.0]), np.zeros((2, 1)))


def test_no_order_fits_changes_that_grow():
    assert observed_order(np.array([4.0, 2.0, 1.0]), 0.5) is None
    assert observed_order(np.array([4.0, 2.0, 1.0]), 4.0) == pytest.approx(2.0)
    assert observed_order(np.array([4.0, 2.0, 1.0]), np.inf) is None


def test_rms():
    assert rms(np.array([3.0, 4.0])) == pytest.approx(np.sqrt(12.5))


@given(st.lists(st.tuples(st.floats(0.0, 10.0), st.floats(0.0, 1.0)), min_size=1, max_size=30))
def test_nothing_beats_the_front_and_the_front_beats_the_rest(points):
    costs, errors = np.array(points).T
    front = pareto_front(costs, errors)
    assert np.all(np.diff(costs[front]) > 0)
    assert np.all(np.diff(errors[front]) < 0)
    for i in range(len(points)):
        no_worse = (costs[front] <= costs[i]) & (errors[front] <= errors[i])
        assert no_worse.any()


def test_front_leaves_out_what_has_no_error():
    assert pareto_front(np.array([1.0, 2.0, 3.0]), np.array([np.nan, 0.2, 0.1])).tolist() == [1, 2]


def test_a_limit_that_has_moved_is_uncertain_by_how_much():
    """Both triples have an order, but the last change is next to nothing by luck."""
    limit = extrapolate(np.array([8.0, 4.0, 2.0, 1.0]), np.array([1.68, 0.68, 0.05, 0.0])[:, None])
    assert limit.asymptotic
    assert limit.uncertainty > 1.0
