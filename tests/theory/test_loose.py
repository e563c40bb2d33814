"""Loose open knots and braids: published factors, limits, what is refused."""

import numpy as np
import pytest

from knotfem import theory
from knotfem.errors import InputError


def test_loose_knots_of_audoly():
    assert theory.loose_knot_force(0.1) == pytest.approx(5e-5)
    assert theory.loose_knot_force(0.1, 0.2) == pytest.approx(5e-5 + 0.2 * 0.492e-3)
    assert theory.loose_knot_force(0.1, 0.2, 2) == pytest.approx(5e-5 + 0.2 * 1.475e-3)


def test_friction_is_that_of_all_contact_forces():
    eps = np.geomspace(0.01, 0.3, 5)
    for turns in (1, 2):
        rubbing = theory.loose_knot_force(eps, 0.3, turns) - theory.loose_knot_force(eps)
        assert rubbing == pytest.approx(0.3 * theory.loose_knot_contact_force(eps, turns))


def test_braids_of_jawed():
    """In dimensions: k = (sqrt(12) r R)^(-1/2), F = 2 pi n mu r B k^3."""
    r, R, B, mu, n = 0.8, 90.0, 1.3, 0.2, 3
    k = (np.sqrt(12.0) * r * R) ** -0.5
    wave_number = theory.braid_wave_number(np.sqrt(r / R))
    assert wave_number == pytest.approx(r * k)
    assert theory.braid_force(wave_number, mu, n) * B / r**2 == pytest.approx(2.0 * np.pi * n * mu * r * B * k**3)
    assert theory.braid_force(0.1, 0.0, 2) == 0.0


def test_two_turns_of_both_laws():
    """Audoly's factor is 0.76 of Jawed's for two turns, where the braid is not long."""
    long = theory.braid_force(theory.braid_wave_number(0.1), 1.0, 2)
    assert theory.loose_knot_contact_force(0.1, 2) / long == pytest.approx(0.757, abs=5e-4)


def test_numbers_give_numbers():
    assert type(theory.loose_knot_force(0.1)) is type(theory.braid_force(0.1, 0.1, 2)) is float
    assert theory.loose_knot_force([0.1, 0.2], [[0.1], [0.2]]).shape == (2, 2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: theory.loose_knot_force(0.0), "eps: out of range"),
        (lambda: theory.loose_knot_force(0.1, -0.1), "friction: out of range"),
        (lambda: theory.loose_knot_force(0.1, 0.1, 3), "turns: no sigma is known; found 3; expected 1 or 2"),
        (lambda: theory.loose_knot_contact_force(-0.1), "eps: out of range"),
        (lambda: theory.braid_wave_number(0.0), "eps: out of range"),
        (lambda: theory.braid_force(0.0, 0.1, 2), "wave_number: out of range"),
        (lambda: theory.braid_force(0.1, -0.1, 2), "friction: out of range"),
        (lambda: theory.braid_force(0.1, 0.1, 0), "turns: out of range"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
