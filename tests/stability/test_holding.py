"""The force that a knot holds, from curves that are known."""

import math

import numpy as np
import pytest
from shapes import report

from knotfem.stability.holding import Holding
from knotfem.stability.slip import SlipMeter
from knotfem.stability.verdict import Signs, in_words, verdict_of


def followed(states: list[tuple[float, float, float, bool]], slip: float = 2.0) -> Holding:
    found = Holding(slip)
    for displacement, force, drawn_in, settled in states:
        found.update(displacement, force, drawn_in, settled=settled)
    return found


def test_the_largest_force_before_the_slip_and_the_one_at_it():
    found = followed([(1.0, 3.0, 0.1, True), (2.0, 2.0, 1.0, True), (3.0, 1.0, 3.0, True), (4.0, 9.0, 4.0, True)])
    assert (found.force, found.displacement) == (3.0, 1.0)
    assert found.slipped
    assert found.slip_force == pytest.approx(1.5)
    assert found.slip_displacement == pytest.approx(2.5)
    assert found.drawn_in == 4.0


def test_the_force_at_the_slip_may_be_the_largest():
    found = followed([(1.0, 1.0, 1.0, True), (2.0, 2.0, 3.0, True)])
    assert found.force == found.slip_force == pytest.approx(1.5)


def test_in_a_jump_the_equilibrium_before_it_counts():
    found = followed([(1.0, 1.0, 0.5, True), (1.0, 5.0, 1.5, False), (1.0, 0.2, 2.5, False), (2.0, 7.0, 3.0, True)])
    assert (found.force, found.slip_force, found.slip_displacement) == (1.0, 1.0, 1.0)


def test_a_knot_that_does_not_slip_bears_at_least_so_much():
    found = followed([(1.0, 1.0, 0.0, True), (2.0, 4.0, -1.0, True)])
    assert (found.force, found.slipped, found.slip_force) == (4.0, False, None)
    assert str(found).startswith("holding force at least 4 N at 2 mm")


def test_lost_at_once():
    assert followed([(1.0, 1.0, 3.0, False)]).force is None


def test_ends_are_drawn_in_past_the_crossing_next_to_them():
    meter = SlipMeter(2, 6.0)
    for ran in (0.0, 1.0, 2.0):
        meter.update(report([(0, 100.0 - ran, 1, 50.0), (0, 200.0 - 0.5 * ran, 1, 80.0 + 0.25 * ran)]))
    assert meter.drawn_in == pytest.approx(np.array([[2.0, -1.0], [0.0, 0.5]]))


def test_an_end_drawn_in_as_far_as_the_step_allows_is_a_slip():
    signs = Signs("", at_rest=False, through=0.0, rate=math.nan, diameter=6.0, drawn_in=6.5)
    assert verdict_of(signs) == "slips"
    assert in_words("slips", signs, "none") == "the knot slips: a free end was drawn in by 6.5 mm"
