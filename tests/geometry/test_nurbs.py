import math

import numpy as np
import pytest

from knotfem.geometry.nurbs import Nurbs, blender_knots


def test_quarter_circle_is_exact() -> None:
    points = np.array([[1.0, 0, 0], [1, 1, 0], [0, 1, 0]])
    arc = Nurbs(2, points, np.array([1.0, math.sqrt(0.5), 1.0]), np.array([0.0, 0, 0, 1, 1, 1]))
    x = arc(np.linspace(0.0, 1.0, 33))
    assert np.linalg.norm(x, axis=1) == pytest.approx(np.ones(33), abs=1e-14)
    assert x[[0, -1]] == pytest.approx(points[[0, 2]], abs=1e-15)


def test_derivative_is_the_difference_quotient() -> None:
    random = np.random.default_rng(3)
    curve = Nurbs(
        3, random.normal(size=(7, 3)), random.uniform(0.5, 2.0, 7), blender_knots(7, 4, endpoint=True, bezier=False)
    )
    t, h = np.linspace(0.1, 3.9, 9) + 0.01, 1e-6
    assert curve.derivative(t) == pytest.approx((curve(t + h) - curve(t - h)) / (2 * h), abs=1e-7)


@pytest.mark.parametrize(
    ("count", "order", "endpoint", "bezier", "knots"),
    [
        (6, 4, True, False, [0, 0, 0, 0, 1, 2, 3, 3, 3, 3]),
        (5, 3, False, False, [0, 1, 2, 3, 4, 5, 6, 7]),
        (7, 4, True, True, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2]),
        (4, 4, True, False, [0, 0, 0, 0, 1, 1, 1, 1]),
        (6, 3, False, True, [0, 0, 1, 1, 2, 2, 3, 3, 4]),
    ],
)
def test_knots_are_blenders(count: int, order: int, endpoint: bool, bezier: bool, knots: list[int]) -> None:
    assert blender_knots(count, order, endpoint=endpoint, bezier=bezier).tolist() == knots


def test_uniform_knots_leave_the_ends_of_the_polygon() -> None:
    points = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
    curve = Nurbs(3, points, np.ones(6), blender_knots(6, 4, endpoint=False, bezier=False))
    assert curve.domain == (3.0, 6.0)
    assert curve(np.array(curve.domain))[:, 0] == pytest.approx([1.0, 4.0])


def test_bezier_knots_pass_through_every_third_point() -> None:
    points = np.random.default_rng(0).normal(size=(7, 3))
    curve = Nurbs(3, points, np.ones(7), blender_knots(7, 4, endpoint=True, bezier=True))
    assert curve(np.array([0.0, 1.0, 2.0])) == pytest.approx(points[::3])
    middle = (points[0] + 3 * points[1] + 3 * points[2] + points[3]) / 8
    assert curve(0.5) == pytest.approx(middle)
