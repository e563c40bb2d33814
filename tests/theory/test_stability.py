"""The friction above which a bowline holds: each mode of failure, their envelope, the paper's figures."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import trapezoid

from knotfem import theory
from knotfem.errors import InputError
from knotfem.theory import PAPER, Parameters
from knotfem.theory.stability import CENTRAL_RODS, WRAPPING_ROD

STIFFNESS = [5.0, 6.0, 7.4, 9.1, 13.9, 25.0]
FITTED = [0.0895, 0.1015, 0.1173, 0.1352, 0.1812, 0.2716]
"""Eq. 4b with the paper's parameters."""


def test_the_wrapping_rod_slips_by_euler():
    assert theory.wrapping_rod_friction() == pytest.approx(0.110, abs=5e-4)
    assert theory.wrapping_rod_friction(np.pi) == pytest.approx(np.log(2.0) / np.pi)


def test_the_fitted_boundary_of_the_paper():
    assert theory.stiff_friction(STIFFNESS) == pytest.approx(FITTED, abs=5e-5)
    assert theory.critical_stiffness(FITTED) == pytest.approx(STIFFNESS, rel=1e-3)


def test_the_envelope_is_the_fitted_boundary_where_rods_are_stiff():
    """At x = 5 and 6 the wrapping rod slips at a higher friction than the fitted boundary."""
    assert theory.critical_friction(STIFFNESS[2:]) == pytest.approx(FITTED[2:], abs=5e-5)
    assert theory.critical_friction(STIFFNESS[:2]) == pytest.approx(np.log(2.0) / (2.0 * np.pi))
    assert list(theory.failure_mode(STIFFNESS)) == [WRAPPING_ROD] * 2 + [CENTRAL_RODS] * 4


def test_central_rods_of_flexible_rods():
    assert theory.central_rods_friction([1e-3, 1.0, 6.4]) == pytest.approx(1.0 / (3.0 * np.pi))


@given(st.floats(1.05, 3.0), st.floats(0.5, 50.0), st.floats(0.01, 1000.0), st.floats(0.0, 1.0))
def test_equation_4b_as_the_paper_writes_it(alpha, beta, x, mu):
    law = Parameters(alpha, beta)
    written = (3.0**alpha * beta / 2.0) ** (1.0 / (alpha - 1.0)) * mu ** (1.0 / (alpha - 1.0))
    assert theory.critical_stiffness(mu, law) == pytest.approx(written, rel=1e-9)
    assert theory.stiff_friction(x, law) == pytest.approx(2.0 * x ** (alpha - 1.0) / (3.0**alpha * beta), rel=1e-9)


def test_how_the_boundary_depends_on_friction():
    """The exponent is 1/(alpha - 1), not the 1.7 of the text: friction of 0.37 in place of 0.30 gives a factor 1.36."""
    assert theory.critical_stiffness(0.37) / theory.critical_stiffness(0.30) == pytest.approx(1.36, abs=5e-3)
    assert theory.critical_stiffness(0.0) == 0.0


@pytest.mark.parametrize("angle", [5.0, 2.0 * np.pi, 7.7])
def test_the_boundary_rises_without_a_jump(angle):
    x = np.geomspace(0.1, 100.0, 5001)
    for boundary in (theory.critical_friction(x, angle=angle), theory.central_rods_friction(x, angle=angle)):
        assert np.all(np.diff(boundary) >= 0.0)
        assert np.abs(np.diff(np.log(boundary))).max() < 0.7 * np.log(x[1] / x[0])
    across = theory.crossing(angle=angle) * np.array([1.0 - 1e-9, 1.0 + 1e-9])
    assert np.ptp(theory.central_rods_friction(across, angle=angle)) < 1e-9


def test_limits_of_the_envelope():
    assert theory.critical_friction(1e-6) == theory.wrapping_rod_friction()
    assert theory.critical_friction(1e4) == theory.stiff_friction(1e4)
    change = theory.critical_stiffness(theory.wrapping_rod_friction())
    assert change == pytest.approx(6.77, abs=5e-3)
    assert theory.failure_mode(0.999 * change) == WRAPPING_ROD
    assert theory.failure_mode(1.001 * change) == CENTRAL_RODS


@given(st.floats(1.0, 30.0), st.floats(0.01, 6.0))
def test_the_wrapping_rod_slips_first_where_rods_are_flexible(angle, x):
    """ln 2 is larger than 2/3: for no angle do the central rods slip first there."""
    law = Parameters(1.5, 3.0 * angle)
    assert theory.crossing(law, angle) > 6.0
    assert theory.central_rods_friction(x, law, angle) == pytest.approx(2.0 / (3.0 * angle))
    assert theory.critical_friction(x, law, angle) == pytest.approx(np.log(2.0) / angle)
    assert theory.failure_mode(x, law, angle) == WRAPPING_ROD


def test_the_wrapping_rod_carries_the_flexible_central_rods_with_its_mean_tension():
    """Friction of a tension that falls exponentially to T0/2 is T0/2 on the whole: Eq. 4a is then Eq. 1."""
    mu, phi = theory.wrapping_rod_friction(), np.linspace(0.0, 2.0 * np.pi, 20001)
    tension = theory.tension_profile(phi, 1.0, mu, 2.0 * np.pi, 1.0)
    mean = trapezoid(tension, phi) / (2.0 * np.pi)
    assert mean == pytest.approx(0.5 / np.log(2.0), rel=1e-6)
    assert theory.flexible_holding_force(mean, mu) == pytest.approx(0.5, rel=1e-6)


def test_what_holds():
    x, mu = np.meshgrid([5.0, 9.1, 25.0], [0.05, 0.12, 0.15, 0.30])
    expected = [[False] * 3, [True, False, False], [True, True, False], [True] * 3]
    assert theory.holds(x, mu).tolist() == expected
    assert theory.holds(9.1, theory.critical_friction(9.1)) is True
    assert theory.holds(9.1, 0.0) is False


def test_the_error_of_the_boundary():
    step = 1e-6
    for x in (3.0, 9.1, 25.0):
        slope = np.array(
            [
                theory.stiff_friction(x, Parameters(1.69 + a, 10.6 + b)) - theory.stiff_friction(x)
                for a, b in ((step, 0.0), (0.0, step))
            ]
        )
        for correlation in (0.0, 0.9, -1.0):
            law = Parameters(1.69, 10.6, 0.04, 1.0, correlation)
            expected = np.sqrt(slope @ law.covariance @ slope) / step
            assert theory.stiff_friction_error(x, law) == pytest.approx(expected, rel=1e-4)
    assert theory.stiff_friction_error(9.1) == pytest.approx(0.0141, abs=5e-5)
    assert theory.stiff_friction_error([5.0, 6.0], Parameters(1.5, 8.0)).tolist() == [0.0, 0.0]


def test_numbers_give_numbers_and_arrays_broadcast():
    for function in (
        theory.stiff_friction,
        theory.stiff_friction_error,
        theory.critical_friction,
        theory.central_rods_friction,
        theory.critical_stiffness,
        theory.wrapping_rod_friction,
    ):
        assert type(function(9)) is float
        assert function([[9.0, 10.0]]).shape == (1, 2)
    assert type(theory.failure_mode(9.0)) is str
    assert theory.critical_friction([[7.0], [9.0]], PAPER, [5.0, 6.0, 7.0]).shape == (2, 3)
    assert theory.failure_mode([[7.0], [9.0]], PAPER, [5.0, 6.0, 7.0]).shape == (2, 3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: theory.critical_friction(0.0), "x: out of range; found 0.0; expected numbers above 0"),
        (lambda: theory.critical_friction([9.1, -1.0]), "x: out of range; found -1.0"),
        (lambda: theory.stiff_friction(np.nan), "x: out of range; found nan; expected finite numbers"),
        (lambda: theory.stiff_friction_error(0.0), "x: out of range"),
        (lambda: theory.central_rods_friction(-1.0), "x: out of range"),
        (lambda: theory.failure_mode(-1.0), "x: out of range"),
        (lambda: theory.wrapping_rod_friction(0.0), "angle: out of range"),
        (lambda: theory.critical_friction(1.0, angle=-1.0), "angle: out of range"),
        (lambda: theory.critical_stiffness(-0.1), "friction: out of range"),
        (lambda: theory.holds(9.1, -0.1), "friction: out of range"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
