"""Fits of alpha and beta: exact data, noise, how often the standard errors hold, what is refused."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from knotfem import theory
from knotfem.errors import InputError
from knotfem.theory import PAPER, Fit, Parameters

LAWS = st.builds(Parameters, st.floats(1.05, 3.0), st.floats(0.5, 50.0))
STIFFNESS = np.geomspace(7.0, 40.0, 8)
WIDTH = 0.01
DRAWS = 2000


def normalised(fits: list[Fit], law: Parameters = PAPER) -> tuple[np.ndarray, np.ndarray]:
    """Errors of alpha and ln beta over their standard errors, shape [draws, 2], and the squares by the covariance."""
    off = np.array([[fit.alpha - law.alpha, fit.beta * np.log(fit.beta / law.beta)] for fit in fits])
    one = off / np.array([[fit.alpha_error, fit.beta_error] for fit in fits])
    squares = [d @ np.linalg.solve(fit.covariance, d) for d, fit in zip(off, fits, strict=True)]
    return one, np.array(squares)


@given(LAWS)
def test_exact_boundaries_give_their_parameters(law):
    fit = theory.fit_boundary(STIFFNESS, theory.stiff_friction(STIFFNESS, law), WIDTH)
    assert (fit.alpha, fit.beta) == pytest.approx((law.alpha, law.beta), rel=1e-6)
    assert fit.residuals == pytest.approx(0.0, abs=1e-9)
    assert fit.spread < 1e-5


@given(LAWS)
def test_exact_forces_give_their_parameters(law):
    tension, friction = np.geomspace(0.01, 0.3, 6), np.linspace(0.1, 0.5, 6)
    force = theory.stiff_holding_force(tension, friction, 1.7, law)
    fit = theory.fit_holding_force(force, tension, friction, 1.7)
    assert (fit.alpha, fit.beta) == pytest.approx((law.alpha, law.beta), rel=1e-6)
    assert fit.alpha_error < 1e-6
    assert np.isnan(fit.spread)


def test_a_fit_is_taken_as_parameters():
    fit = theory.fit_boundary(STIFFNESS, theory.stiff_friction(STIFFNESS), WIDTH)
    assert theory.critical_friction(9.1, fit) == pytest.approx(0.1352, abs=5e-5)
    assert 0.0 < theory.stiff_friction_error(9.1, fit) < 0.3 * WIDTH
    with pytest.raises(dataclasses.FrozenInstanceError):
        fit.alpha = 2.0  # pyright: ignore[reportAttributeAccessIssue]


def test_residuals_are_of_what_was_measured():
    friction = theory.stiff_friction(STIFFNESS) * np.array([1, 1, 1, 1, 1.1, 1, 1, 1])
    for width in (None, WIDTH):
        fit = theory.fit_boundary(STIFFNESS, friction, width)
        assert fit.residuals == pytest.approx(np.log(friction / theory.stiff_friction(STIFFNESS, fit)))
    force = theory.stiff_holding_force(STIFFNESS, 0.2, 100.0) * np.array([1, 1, 1, 1, 1.1, 1, 1, 1])
    fit = theory.fit_holding_force(force, STIFFNESS, 0.2, 100.0)
    assert fit.residuals == pytest.approx(np.log(force / theory.stiff_holding_force(STIFFNESS, 0.2, 100.0, fit)))


def test_errors_agree_with_those_of_a_general_fit():
    rng = np.random.default_rng(1)
    error = rng.uniform(0.002, 0.02, STIFFNESS.size)
    friction = theory.stiff_friction(STIFFNESS) + 0.5 * error * rng.standard_normal(STIFFNESS.size)

    def law(x, alpha, beta):
        return np.log(2.0 * x ** (alpha - 1.0) / (3.0**alpha * beta))

    for given_error in (error, None):
        sigma = None if given_error is None else given_error / friction
        found, covariance = curve_fit(
            law,
            STIFFNESS,
            np.log(friction),
            (1.5, 8.0),
            sigma,
            absolute_sigma=sigma is not None,
            ftol=1e-14,
            xtol=1e-14,
        )
        width = None if given_error is None else np.sqrt(12.0) * given_error
        fit = theory.fit_boundary(STIFFNESS, friction, width)
        assert (fit.alpha, fit.beta) == pytest.approx(tuple(found), rel=1e-6)
        assert fit.covariance == pytest.approx(covariance, rel=1e-3)


def test_standard_errors_of_a_bracketed_boundary_hold():
    """Thresholds are anywhere in their brackets, whose places are known."""
    rng = np.random.default_rng(2)
    true = theory.stiff_friction(STIFFNESS)
    fits = [
        theory.fit_boundary(STIFFNESS, true + WIDTH * rng.uniform(-0.5, 0.5, true.size), WIDTH) for _ in range(DRAWS)
    ]
    one, squares = normalised(fits)
    assert np.all(np.abs(one.mean(axis=0)) < 0.08)
    assert np.all(np.mean(np.abs(one) < 1.0, axis=0) == pytest.approx(0.72, abs=0.05))
    assert np.all(np.mean(np.abs(one) < 2.0, axis=0) > 0.95)
    assert squares.mean() == pytest.approx(1.75, abs=0.25)


def test_standard_errors_from_residuals_hold():
    rng = np.random.default_rng(3)
    tension = np.geomspace(0.02, 0.3, 30)
    true = theory.stiff_holding_force(tension, 0.3, 1.0)
    fits = [
        theory.fit_holding_force(true * np.exp(0.1 * rng.standard_normal(30)), tension, 0.3, 1.0) for _ in range(DRAWS)
    ]
    one, squares = normalised(fits)
    assert np.all(np.mean(np.abs(one) < 1.0, axis=0) == pytest.approx(0.674, abs=0.03))
    assert np.all(np.mean(np.abs(one) < 2.0, axis=0) == pytest.approx(0.945, abs=0.02))
    assert squares.mean() == pytest.approx(2.15, abs=0.2)


@pytest.mark.parametrize("claimed", [1.0, 0.2])
def test_standard_errors_hold_where_noise_is_larger_than_claimed(claimed):
    rng = np.random.default_rng(4)
    tension = np.geomspace(0.02, 0.3, 30)
    true = theory.stiff_holding_force(tension, 0.3, 1.0)
    noise = 0.05 * true
    fits = [
        theory.fit_holding_force(true + noise * rng.standard_normal(30), tension, 0.3, 1.0, claimed * noise)
        for _ in range(DRAWS)
    ]
    one, _ = normalised(fits)
    assert np.mean([fit.spread for fit in fits]) == pytest.approx(1.0 / claimed, rel=0.03)
    assert np.all(np.mean(np.abs(one) < 1.0, axis=0) == pytest.approx(0.69, abs=0.04))


def test_points_of_small_error_count_more():
    friction = theory.stiff_friction(STIFFNESS)
    friction[0] *= 1.3
    width = np.full(STIFFNESS.size, WIDTH)
    width[0] = 100.0 * WIDTH
    fit = theory.fit_boundary(STIFFNESS, friction, width)
    assert fit.alpha == pytest.approx(1.69, abs=1e-3)
    assert theory.fit_boundary(STIFFNESS, friction, WIDTH).alpha < 1.65


X, MU = [7.0, 10.0, 20.0], [0.11, 0.14, 0.23]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: theory.fit_boundary(X[:2], MU[:2], 0.01),
            r"too few points for a fit; found x \(2,\), friction \(2,\)",
        ),
        (lambda: theory.fit_boundary([], [], 0.01), "too few points for a fit"),
        (lambda: theory.fit_boundary(7.0, 0.1), "too few points for a fit"),
        (lambda: theory.fit_boundary([X], [MU]), "too few points for a fit"),
        (lambda: theory.fit_boundary(X, MU[:2]), r"the shapes do not agree; found x \(3,\), friction \(2,\)"),
        (lambda: theory.fit_boundary(X, [0.11, np.nan, 0.23]), "friction: out of range; found nan"),
        (lambda: theory.fit_boundary(X, [0.11, 0.0, 0.23]), "friction: out of range; found 0.0"),
        (lambda: theory.fit_boundary([7.0, -1.0, 20.0], MU), "x: out of range; found -1.0"),
        (lambda: theory.fit_boundary(X, MU, 0.0), "width: out of range; found 0.0"),
        (lambda: theory.fit_boundary(X, MU, [0.01, np.inf, 0.01]), "width: out of range; found inf"),
        (lambda: theory.fit_boundary([9.0, 9.0, 9.0], MU), "all points have the same tension over B kappa"),
        (lambda: theory.fit_boundary(X, MU[::-1]), "alpha: out of range; found .*; expected a number above 1"),
        (lambda: theory.fit_holding_force([1.0, 2.0], [1.0, 2.0], 0.1, 1.0), "too few points for a fit"),
        (lambda: theory.fit_holding_force([1.0, 2.0, -3.0], X, 0.1, 1.0), "force: out of range; found -3.0"),
        (lambda: theory.fit_holding_force(X, [1.0, 0.0, 3.0], 0.1, 1.0), "tension: out of range; found 0.0"),
        (lambda: theory.fit_holding_force(X, X, 0.0, 1.0), "friction: out of range; found 0.0"),
        (lambda: theory.fit_holding_force(X, X, 0.1, np.inf), "bending_force: out of range; found inf"),
        (lambda: theory.fit_holding_force(X, X, 0.1, 1.0, -1.0), "error: out of range; found -1.0"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
