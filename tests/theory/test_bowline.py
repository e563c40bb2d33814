"""The force at which the central rods slip: both laws, where they cross, what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem import theory
from knotfem.errors import InputError
from knotfem.theory import PAPER, Parameters

LAWS = st.builds(Parameters, st.floats(1.05, 3.0), st.floats(0.5, 50.0))


def test_the_parameters_of_the_paper():
    assert (PAPER.alpha, PAPER.alpha_error, PAPER.beta, PAPER.beta_error) == (1.69, 0.04, 10.6, 1.0)
    assert PAPER.covariance == pytest.approx(np.diag([0.0016, 1.0]))
    linked = Parameters(1.5, 8.0, 0.1, 2.0, correlation=-0.5)
    assert linked.covariance == pytest.approx(np.array([[0.01, -0.1], [-0.1, 4.0]]))


def test_both_laws():
    assert theory.flexible_holding_force(2.0, 0.25) == pytest.approx(np.pi)
    assert theory.flexible_holding_force(2.0, 0.25, angle=3.0) == pytest.approx(1.5)
    assert theory.stiff_holding_force(2.0, 0.1, 2.0) == pytest.approx(10.6 * 0.1 * 2.0)
    assert theory.stiff_holding_force(1.0, 0.1, 2.0, Parameters(2.0, 4.0)) == pytest.approx(0.2)


@given(LAWS, st.floats(1.0, 10.0))
def test_the_laws_cross_at_one_force(law, angle):
    """With T0 = 1: T = 3/4, B kappa^2 = x/4."""
    x = theory.crossing(law, angle)
    stiff, flexible = (
        theory.stiff_holding_force(0.75, 0.2, 0.25 * x, law),
        theory.flexible_holding_force(0.75, 0.2, angle),
    )
    assert stiff == pytest.approx(flexible, rel=1e-9)


def test_where_the_laws_of_the_paper_cross():
    assert theory.crossing() == pytest.approx(6.40, abs=5e-3)
    assert theory.crossing(Parameters(1.69, 2.0 * np.pi)) == pytest.approx(3.0)
    assert type(theory.crossing()) is float


@given(LAWS)
def test_each_law_applies_in_its_limit(law):
    scale = 2.0
    change = scale * (2.0 * np.pi / law.beta) ** (1.0 / (law.alpha - 1.0))
    for tension in np.array([1.0001, 3.0, 100.0]) * change:
        assert theory.holding_force(tension, 0.3, scale, law) == theory.flexible_holding_force(tension, 0.3)
    for tension in np.array([0.9999, 0.3, 0.01]) * change:
        assert theory.holding_force(tension, 0.3, scale, law) == theory.stiff_holding_force(tension, 0.3, scale, law)


def test_the_force_rises_with_tension_and_friction_and_falls_with_bending():
    rising = np.geomspace(1e-2, 1e2, 200)
    assert np.all(np.diff(theory.holding_force(rising, 0.3, 1.0)) > 0.0)
    assert np.all(np.diff(theory.holding_force(1.0, rising, 1.0)) > 0.0)
    assert np.all(np.diff(theory.holding_force(1.0, 0.3, rising)) <= 0.0)
    assert theory.holding_force(1.0, 0.0, 1.0) == 0.0


def test_the_force_has_no_jump():
    tension = np.geomspace(0.1, 1.0, 20001)
    force = theory.holding_force(tension, 0.3, 1.0)
    assert np.abs(np.diff(np.log(force))).max() < 1.7 * np.log(tension[1] / tension[0])


def test_numbers_give_numbers_and_arrays_broadcast():
    assert type(theory.holding_force(1, 0.3, 1)) is float
    assert theory.holding_force([[1.0], [2.0]], 0.3, [1.0, 2.0, 3.0]).shape == (2, 3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: theory.flexible_holding_force(0.0, 0.1), "tension: out of range"),
        (lambda: theory.flexible_holding_force(1.0, -0.1), "friction: out of range"),
        (lambda: theory.flexible_holding_force(1.0, 0.1, 0.0), "angle: out of range"),
        (lambda: theory.stiff_holding_force(1.0, 0.1, 0.0), "bending_force: out of range"),
        (lambda: theory.stiff_holding_force(-1.0, 0.1, 1.0), "tension: out of range"),
        (lambda: theory.stiff_holding_force(1.0, [0.1, -0.2], 1.0), "friction: out of range; found -0.2"),
        (lambda: theory.crossing(angle=-1.0), "angle: out of range"),
        (lambda: Parameters(1.0, 10.0), "alpha: out of range; found 1.0; expected a number above 1"),
        (lambda: Parameters(np.nan, 10.0), "alpha: out of range"),
        (lambda: Parameters(1.5, 0.0), "beta: out of range"),
        (lambda: Parameters(1.5, 1.0, -0.1), "alpha_error: out of range"),
        (lambda: Parameters(1.5, 1.0, 0.1, -0.1), "beta_error: out of range"),
        (lambda: Parameters(1.5, 1.0, correlation=1.1), "correlation: out of range"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
