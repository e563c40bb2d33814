"""Length of time steps as a pure function: nothing but its arguments decides."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.pace import Outcome, Pace, Trial

CONTROLLER = StepController(first=0.1, smallest=1e-3, largest=0.4, move=0.3)
TIMES = np.array([0.25, 0.37, 1.0])


def following(dt: float, wanted: float, iterations: int, moved: float, rejected: int) -> float:
    """Length wanted after a step of length `dt`."""
    pace = CONTROLLER.after_success(Pace(wanted), Trial(dt, False), Outcome(iterations, moved, rejected))
    assert pace == Pace(pace.advance)
    return pace.advance


def test_it_has_no_state():
    with pytest.raises(FrozenInstanceError):
        CONTROLLER.first = 0.2  # pyright: ignore[reportAttributeAccessIssue]
    answers = [following(0.1, 0.1, 5, 0.1, 0) for _ in range(3)]
    assert len(set(answers)) == 1
    assert StepController(0.1, 1e-3, 0.4, 0.3) == CONTROLLER


def test_a_step_far_from_the_next_output_time_has_the_length_wanted():
    assert CONTROLLER.length(0.1, 0.0, TIMES) == (0.1, False)
    assert CONTROLLER.length(0.15, 0.0, TIMES) == (0.15, False)


def test_a_step_that_would_reach_the_next_output_time_ends_there():
    assert CONTROLLER.length(0.3, 0.0, TIMES) == (0.25, True)
    assert CONTROLLER.length(0.25, 0.0, TIMES) == (0.25, True)
    assert CONTROLLER.length(0.25 * (1.0 - 1e-10), 0.0, TIMES) == (0.25, True)
    assert CONTROLLER.length(5.0, 0.37, TIMES) == (pytest.approx(0.63), True)


def test_a_step_that_would_all_but_reach_it_is_halved():
    """So that no tiny step is left over."""
    assert CONTROLLER.length(0.2, 0.0, TIMES) == (0.125, False)
    assert CONTROLLER.length(0.1501, 0.0, TIMES) == (0.125, False)


def test_an_output_time_that_is_reached_but_for_rounding_is_behind():
    length, _ = CONTROLLER.length(5.0, 0.25 - 1e-14, TIMES)
    assert length == pytest.approx(0.12, rel=1e-9)
    late = np.array([1e6, 1e6 + 1.0])
    assert CONTROLLER.length(5.0, 1e6 - 1e-8, late) == (pytest.approx(1.0, abs=1e-6), True)


@settings(deadline=None, max_examples=200)
@given(
    st.floats(1e-3, 5.0),
    st.lists(st.floats(0.01, 3.0), min_size=1, max_size=6).map(lambda gaps: np.cumsum(gaps)),
)
def test_every_output_time_is_met_exactly_and_no_step_is_longer_than_wanted(dt, times):
    now, met = 0.0, []
    for _ in range(100_000):
        length, at_output = CONTROLLER.length(dt, now, times)
        assert 0.0 < length <= dt * (1.0 + 1e-9)
        now += length
        if at_output:
            met.append(now)
        if now >= times[-1] * (1.0 - 1e-12):
            break
    np.testing.assert_allclose(met, times, rtol=1e-12)


def test_easy_steps_grow_and_hard_ones_shrink():
    still = 0.0
    assert following(0.1, 0.1, CONTROLLER.few, still, 0) == pytest.approx(0.14)
    assert following(0.1, 0.1, CONTROLLER.few + 1, still, 0) == pytest.approx(0.1)
    assert following(0.1, 0.1, CONTROLLER.many, still, 0) == pytest.approx(0.07)


def test_after_rejections_the_next_step_is_no_longer():
    assert following(0.04, 0.04, 3, 0.0, 2) == pytest.approx(0.04)
    assert following(0.04, 0.04, 20, 0.0, 1) == pytest.approx(0.04)


def test_the_next_step_aims_at_the_move():
    assert following(0.1, 0.1, 3, 0.6, 0) == pytest.approx(0.05)
    assert following(0.1, 0.1, 3, 0.25, 0) == pytest.approx(0.12)
    assert following(0.1, 0.1, 3, 0.01, 0) == pytest.approx(0.14)


def test_a_step_cut_short_by_an_output_time_does_not_shorten_the_next():
    """One of 0.01 s where 0.2 s were wanted: the length wanted stays the base, the move counts by its own step."""
    assert following(0.01, 0.2, 3, 0.0, 0) == pytest.approx(0.28)
    assert following(0.01, 0.2, 3, 0.03, 0) == pytest.approx(0.1)
    assert following(0.15, 0.2, 3, 0.0, 0) == pytest.approx(0.21)


@settings(deadline=None)
@given(st.floats(1e-3, 0.4), st.floats(1e-3, 0.4), st.integers(1, 60), st.floats(0.0, 1e3), st.integers(0, 5))
def test_lengths_stay_within_bounds(dt, wanted, iterations, moved, rejected):
    found = following(dt, wanted, iterations, moved, rejected)
    assert CONTROLLER.smallest <= found <= CONTROLLER.largest


def test_failures_cut_until_the_smallest_step_has_failed():
    pace, tried = CONTROLLER.start(), []
    while pace is not None:
        tried.append(pace.advance)
        pace = CONTROLLER.after_failure(pace, Trial(pace.advance, False))
    np.testing.assert_allclose(tried, 0.1 * 0.4 ** np.arange(7))
    assert tried[-1] <= CONTROLLER.smallest < tried[-2]


def test_a_step_that_leaps_is_too_far_unless_it_is_the_smallest():
    limit = CONTROLLER.most_move * CONTROLLER.move
    assert not CONTROLLER.too_far(limit, Trial(0.1, False))
    assert CONTROLLER.too_far(1.0001 * limit, Trial(0.1, False))
    assert not CONTROLLER.too_far(1e3, Trial(CONTROLLER.smallest, False))


def test_nothing_is_tried_past_the_last_output_time():
    assert CONTROLLER.trial(CONTROLLER.start(), 1.0, TIMES) is None
    assert CONTROLLER.trial(CONTROLLER.start(), 1.0 - 1e-13, TIMES) is None
    assert CONTROLLER.trial(Pace(0.3), 0.0, TIMES) == Trial(0.25, True)


def test_in_real_time_rates_are_taken_over_the_step():
    trial = CONTROLLER.trial(CONTROLLER.start(), 0.0, TIMES)
    assert trial is not None
    assert trial.rates_over is None
    assert trial.dt == trial.advance == 0.1
