"""The capstan: Euler's law, the law of a thick rope, its inverse, tension along the rope."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem import theory
from knotfem.errors import InputError

FRICTIONS, ANGLES, THICKNESSES = st.floats(1e-3, 2.0), st.floats(0.1, 20.0), st.floats(0.0, 0.95)


def test_a_thin_rope_follows_euler():
    assert theory.capstan_exponent(0.33) == pytest.approx(0.33, rel=1e-14)
    assert theory.tension_ratio(0.25, 2.0 * np.pi) == pytest.approx(np.exp(0.5 * np.pi), rel=1e-14)
    assert theory.tension_ratio(0.33, np.pi, 1e-7) == pytest.approx(np.exp(0.33 * np.pi), rel=1e-6)


@given(FRICTIONS, THICKNESSES)
def test_a_thick_rope_follows_the_quadratic(mu, a):
    rate = theory.capstan_exponent(mu, a)
    assert mu * a * rate**2 + rate == pytest.approx(mu * (1.0 - a), rel=1e-12)
    assert 0.0 < rate <= mu


def test_the_rod_on_the_cylinder_of_the_paper():
    assert theory.tension_ratio(0.33, np.pi, 3.0 / 13.0) == pytest.approx(2.187, abs=5e-4)


def test_without_friction_or_contact_tension_is_the_same_on_both_sides():
    assert theory.tension_ratio(0.0, 5.0, 0.3) == 1.0
    assert theory.tension_ratio(0.4, 0.0) == 1.0


def test_the_ratio_rises_with_friction_and_angle_and_falls_with_thickness():
    rising = np.linspace(0.05, 0.9, 30)
    assert np.all(np.diff(theory.tension_ratio(rising, np.pi, 0.2)) > 0.0)
    assert np.all(np.diff(theory.tension_ratio(0.3, rising, 0.2)) > 0.0)
    assert np.all(np.diff(theory.tension_ratio(0.3, np.pi, rising)) < 0.0)


@given(FRICTIONS, ANGLES, THICKNESSES)
def test_the_friction_of_a_ratio(mu, phi, a):
    ratio = theory.tension_ratio(mu, phi, a)
    assert theory.capstan_friction(ratio, phi, a) == pytest.approx(mu, rel=1e-6)


def test_a_thick_rope_has_a_largest_ratio():
    most = np.exp(np.sqrt(0.6 / 0.4) * np.pi)
    assert np.isfinite(theory.capstan_friction(0.999 * most, np.pi, 0.4))
    assert theory.capstan_friction(1.001 * most, np.pi, 0.4) == np.inf
    assert theory.tension_ratio(1e6, np.pi, 0.4) == pytest.approx(most, rel=1e-5)


def test_tension_along_the_rope():
    load, mu, phi, rho, a = 3.0, 0.33, np.pi, 13.0, 3.0 / 13.0
    s = np.linspace(-10.0, rho * phi + 10.0, 20001)
    tension = theory.tension_profile(s, load, mu, phi, rho, a)
    ahead, behind = s <= 0.0, s >= rho * phi
    assert np.all(tension[ahead] == load)
    assert tension[behind] == pytest.approx(load / theory.tension_ratio(mu, phi, a))
    touching = ~ahead & ~behind
    rate = -np.gradient(np.log(tension[touching]), s[touching])
    assert rate == pytest.approx(theory.capstan_exponent(mu, a) / rho)
    assert np.abs(np.diff(tension)).max() < 1e-3


def test_numbers_give_numbers_and_arrays_broadcast():
    assert type(theory.tension_ratio(0.3, np.pi)) is float
    assert type(theory.tension_profile(1.0, 2.0, 0.3, np.pi, 13.0)) is float
    assert theory.tension_ratio([[0.1], [0.2]], [1.0, 2.0, 3.0]).shape == (2, 3)
    assert theory.tension_ratio([0.1], 1.0).shape == (1,)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: theory.tension_ratio(-0.1, 1.0), "friction: out of range; found -0.1; expected numbers from 0 on"),
        (lambda: theory.tension_ratio([0.1, np.nan], 1.0), "friction: out of range; found nan; expected finite"),
        (lambda: theory.tension_ratio("much", 1.0), "friction: not a number"),
        (lambda: theory.tension_ratio(0.1, np.inf), "angle: out of range; found inf"),
        (lambda: theory.tension_ratio(0.1, -1.0), "angle: out of range; found -1.0"),
        (lambda: theory.capstan_exponent(0.1, 1.0), "thickness: out of range; found 1.0"),
        (lambda: theory.capstan_friction(0.5, 1.0), "ratio: out of range; found 0.5; expected numbers from 1 on"),
        (lambda: theory.capstan_friction(2.0, 0.0), "angle: out of range; found 0.0; expected numbers above 0"),
        (lambda: theory.tension_profile(0.0, 1.0, 0.1, 1.0, 0.0), "radius: out of range"),
        (lambda: theory.tension_profile(0.0, -1.0, 0.1, 1.0, 1.0), "load: out of range"),
        (lambda: theory.tension_profile(np.nan, 1.0, 0.1, 1.0, 1.0), "arclength: out of range"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
