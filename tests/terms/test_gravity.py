import numpy as np
import pytest
from derivatives import gradient_error, residual, tangent
from specimens import make_rod

from knotfem.terms.gravity import Gravity


def test_weight_is_mass_times_acceleration_and_derives_from_the_energy():
    rod = make_rod(12.0, 6)
    gravity = Gravity(rod.mass, np.array([0.0, -9810.0, 100.0]))
    x = rod.mesh.nodes
    f = residual([gravity], x)
    np.testing.assert_allclose(f.sum(axis=0), -rod.mass.sum() * gravity.acceleration)
    assert gradient_error(gravity.energy, f, x) < 1e-9
    assert gradient_error(gravity.merit, f, x) < 1e-9
    assert np.abs(tangent([gravity], x)).max() == 0.0


def test_section_matched_in_bending_weighs_what_the_circle_does():
    rod = make_rod(600.0, 300, section=44)
    assert rod.mass.sum() == pytest.approx(1.16e-9 * np.pi * 9.0 * 600.0, rel=1e-3)
