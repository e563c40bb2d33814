"""scikit-fem's elements and rules in this program's numbering, against closed forms."""

import numpy as np
import pytest

from knotfem.mesh.reference import gauss_line, gauss_square, hexahedron, quadrilateral

CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)


def lagrange(nodes: np.ndarray, order: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tensor products of Lagrange's polynomials, by hand: values (p, n) and rates (p, n, d)."""
    x = x[:, None, :]
    if order == 1:
        line, slope = 0.5 * (1 + nodes * x), 0.5 * nodes + 0 * x
    else:
        cases = [nodes == -1, nodes == 0, nodes == 1]
        line = np.select(cases, [0.5 * x * (x - 1), 1 - x * x, 0.5 * x * (x + 1)])
        slope = np.select(cases, [x - 0.5, -2 * x, x + 0.5])
    parts = []
    for d in range(nodes.shape[1]):
        others = np.delete(line, d, axis=2).prod(axis=2)
        parts.append(slope[..., d] * others)
    return line.prod(axis=2), np.stack(parts, axis=2)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("make", [quadrilateral, hexahedron])
def test_shapes_are_lagranges(make, order):
    element = make(order)
    points = np.random.default_rng(0).uniform(-1, 1, (20, element.nodes.shape[1]))
    for found, expected in zip(element.at(points), lagrange(element.nodes, order, points), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-14)


def test_numbering():
    np.testing.assert_array_equal(quadrilateral(1).nodes, CORNERS)
    np.testing.assert_array_equal(quadrilateral(2).nodes[:4], CORNERS)
    np.testing.assert_array_equal(quadrilateral(2).nodes[4:8], 0.5 * (CORNERS + np.roll(CORNERS, -1, axis=0)))
    np.testing.assert_array_equal(quadrilateral(2).nodes[8], [0, 0])
    for order in (1, 2):
        flat, levels = quadrilateral(order).nodes, np.linspace(-1, 1, order + 1)
        nodes = hexahedron(order).nodes.reshape(order + 1, len(flat), 3)
        for level, height in zip(nodes, levels, strict=True):
            np.testing.assert_array_equal(level[:, :2], flat)
            np.testing.assert_array_equal(level[:, 2], height)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_rules_are_gausss(count):
    points, weights = gauss_line(count)
    expected = np.polynomial.legendre.leggauss(count)
    np.testing.assert_allclose(points, expected[0], atol=1e-15)
    np.testing.assert_allclose(weights, expected[1], atol=1e-15)
    at, share = gauss_square(count)
    for i in range(2 * count):
        for j in range(2 * count):
            exact = (0 if i % 2 else 2 / (i + 1)) * (0 if j % 2 else 2 / (j + 1))
            assert share @ (at[:, 0] ** i * at[:, 1] ** j) == pytest.approx(exact, abs=1e-14)


def test_order_of_points():
    np.testing.assert_allclose(gauss_square(2)[0], CORNERS / np.sqrt(3), atol=1e-15)
    line = gauss_line(3)[0]
    np.testing.assert_allclose(gauss_square(3)[0], [(x, y) for y in line for x in line], atol=1e-15)


def test_nobody_can_change_a_rule():
    with pytest.raises(ValueError, match="read-only"):
        gauss_line(2)[0][0] = 0.0
