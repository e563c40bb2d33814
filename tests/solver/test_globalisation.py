"""The parts of Newton's method by themselves: line search, damping, reuse, tolerance."""

import numpy as np
import pytest

from knotfem.solver.nonlinear.damping import LevenbergMarquardt
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.reuse import Chord
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Imbalance


def test_a_step_that_lowers_the_merit_is_taken_whole():
    assert Armijo().fraction(lambda part: (part - 1.0) ** 2, -2.0) == 1.0


def test_a_step_too_long_is_shortened_to_the_minimum_of_the_parabola():
    """The merit falls to a quarter of the step; interpolation of a parabola finds that at once."""
    assert Armijo().fraction(lambda part: (part - 0.25) ** 2, -0.5) == pytest.approx(0.25)


def test_one_shortening_is_bounded_and_so_is_their_number():
    search = Armijo(attempts=3)
    assert search.fraction(lambda part: part, 0.0) == pytest.approx(search.shortest**3)
    assert Armijo(attempts=2).fraction(lambda part: np.inf if part else 0.0, -1.0) == pytest.approx(0.01)


def test_an_increase_within_rounding_counts_as_none():
    assert Armijo().fraction(lambda part: 1e6 + 1e-5 * part, 0.0) == 1.0
    assert Armijo().fraction(lambda part: 1e6 + 1.0 * part, 0.0) < 1.0


def test_damping_rises_to_its_cap_and_falls_to_nothing():
    rule = LevenbergMarquardt(start=0.01, cap=1.0)
    values, value = [], 0.0
    while not rule.exhausted(value):
        value = rule.raised(value)
        values.append(value)
    np.testing.assert_allclose(values, [0.01, 0.04, 0.16, 0.64, 1.0])
    assert rule.raised(1.0) == 1.0
    assert rule.lowered(0.16) == pytest.approx(0.08)
    assert rule.released(0.16) == pytest.approx(0.04)
    assert rule.lowered(0.009) == rule.released(0.009) == 0.0


def test_factorisation_is_reused_where_the_next_excess_is_far_within_tolerance():
    assert Chord(10.0).promising(1e3, 1.0)
    assert not Chord(10.0).promising(9.0, 1.0)
    assert not Chord(np.inf).promising(1e300, 1e-300)


def test_excess_is_the_worse_of_nodes_and_resultants():
    tolerance = ForceTolerance(node=1e-5, resultant=1e-4)
    assert tolerance.excess(Imbalance(2e-5, 1e-4)) == pytest.approx(2.0)
    assert tolerance.excess(Imbalance(1e-6, 3e-4)) == pytest.approx(3.0)
    assert tolerance.excess(Imbalance()) == np.inf
    assert ForceTolerance.of(2e-6).node == 2e-6
    assert ForceTolerance.of(2e-6).resultant == pytest.approx(2e-5)


def test_loosened_tolerance_keeps_its_proportions():
    tolerance = ForceTolerance(node=1e-5, resultant=3e-4)
    loose = tolerance.loosened(1e-3)
    assert (loose.node, loose.resultant) == (pytest.approx(1e-3), pytest.approx(3e-2))
    assert tolerance.loosened(1e-7) == tolerance
