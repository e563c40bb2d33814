import numpy as np
import pytest

from knotfem.geometry.curve import interpolate


def test_interpolates_with_chord_length_and_natural_ends() -> None:
    points = np.array([[0.0, 0, 0], [3, 4, 0], [3, 4, 12], [4, 6, 14]])
    curve = interpolate(points)
    assert curve.spans == pytest.approx([0.0, 5.0, 17.0, 20.0])
    assert curve.domain == (0.0, 20.0)
    assert curve(curve.spans) == pytest.approx(points)
    assert curve.spline(np.array([0.0, 20.0]), 2) == pytest.approx(np.zeros((2, 3)), abs=1e-12)


def test_derivative_is_the_difference_quotient() -> None:
    curve = interpolate(np.random.default_rng(1).normal(size=(8, 3)))
    t, h = 0.4 * curve.domain[1], 1e-5
    assert curve.derivative(t) == pytest.approx((curve(t + h) - curve(t - h)) / (2 * h), rel=1e-6)
