import numpy as np
import pytest

from knotfem.geometry.measures import arclength, curvature, turning_angles, vertex_means


def test_arclength_and_curvature_of_a_circle() -> None:
    a = np.linspace(0.0, 3.0, 31)
    x = 4.0 * np.column_stack([np.cos(a), np.sin(a), 0 * a])
    assert curvature(x) == pytest.approx(np.full(31, 0.25), rel=1e-12)
    assert arclength(x)[-1] == pytest.approx(30 * 8.0 * np.sin(0.05))
    assert turning_angles(x) == pytest.approx(np.full(29, 0.1))
    assert curvature(x[:2]).tolist() == [0.0, 0.0]


def test_curvature_between_uneven_edges() -> None:
    corner = [[-1.0, 0, 0], [0, 0, 0], [3 * np.cos(0.4), 3 * np.sin(0.4), 0]]
    assert curvature(corner) == pytest.approx(np.full(3, np.sin(0.2)))


def test_means_at_vertices_and_the_values_of_the_outer_edges() -> None:
    assert vertex_means(np.array([1.0, 3.0, 7.0])) == pytest.approx([1.0, 2.0, 5.0, 7.0])
    assert vertex_means(np.array([[1.0, 2.0]])) == pytest.approx(np.array([[1.0, 2.0], [1.0, 2.0]]))
