"""The force that a knot holds, from curves that are known."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import D

from knotfem.stability.crossings import Crossing
from knotfem.stability.drawn_in import DrawnIn
from knotfem.stability.holding import Holding
from knotfem.stability.unit import Line
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


def crossed(ran: float, turned: float = 0.0) -> list[Line]:
    """A straight rod along x that has run by so much past another along z, both turned about y."""
    s, z = np.linspace(0.0, 200.0, 101), np.linspace(0.0, 100.0, 51)
    spin = Rotation.from_rotvec([0.0, turned, 0.0])
    along = spin.apply(np.stack([s - 100.0 + ran, np.full_like(s, D), 0.0 * s], axis=1))
    across = spin.apply(np.stack([0.0 * z, 0.0 * z, z - 50.0], axis=1))
    return [Line(along, s), Line(across, z)]


def crossing(place: float, other: float, force: float = 1.0) -> Crossing:
    return Crossing((0, 1), (place, other), (0.0, 0.0), force, 1.0)


def test_an_end_is_drawn_in_past_a_strand_whatever_the_knot_does_as_a_whole():
    drawn = DrawnIn(2, D)
    for ran, turned in ((0.0, 0.0), (1.0, 0.3), (2.5, 0.6)):
        drawn.update([crossing(100.0 - ran, 50.0)], crossed(ran, turned))
    assert drawn.lengths == pytest.approx(np.array([[2.5, -2.5], [0.0, 0.0]]), abs=1e-9)


def test_a_contact_that_wanders_and_one_that_bears_nothing_draw_nothing_in():
    drawn = DrawnIn(2, D)
    for wander in (0.0, 3.0, 6.0):
        drawn.update([crossing(100.0 + wander, 50.0), crossing(150.0 - 5.0 * wander, 50.0, 0.05)], crossed(0.0))
    assert drawn.lengths == pytest.approx(np.zeros((2, 2)))


def test_past_an_obstacle_a_point_in_space_counts():
    drawn = DrawnIn(1, D)
    for ran in (0.0, 1.0, 2.0):
        drawn.update([Crossing((0, -1), (100.0 - ran, np.nan), (0.0, 0.0), 1.0, 1.0)], crossed(ran)[:1])
    assert drawn.lengths == pytest.approx(np.array([[2.0, -2.0]]))


def test_an_end_drawn_in_as_far_as_the_step_allows_is_a_slip():
    signs = Signs("", at_rest=False, through=0.0, rate=math.nan, diameter=6.0, drawn_in=6.5)
    assert verdict_of(signs) == "slips"
    assert in_words("slips", signs, "none") == "the knot slips: a free end was drawn in by 6.5 mm"
