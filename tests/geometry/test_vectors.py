import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem.errors import InputError
from knotfem.geometry.vectors import along_and_across, angles_between, perpendicular, unit, unit_edges, unit_vectors


def test_unit_has_length_one() -> None:
    assert unit([0.0, 3.0, 4.0]) == pytest.approx([0.0, 0.6, 0.8])


@pytest.mark.parametrize("vector", [[0, 0, 0], [1, 0], [np.nan, 0, 0]])
def test_unit_refuses_what_has_no_direction(vector: list) -> None:
    with pytest.raises(InputError, match="not a direction"):
        unit(vector)


def test_unit_vectors_are_scaled_one_by_one() -> None:
    assert unit_vectors(np.array([[0.0, 3, 4], [-2, 0, 0]])) == pytest.approx(np.array([[0, 0.6, 0.8], [-1, 0, 0]]))


def test_unit_edges_follow_the_polyline() -> None:
    edges = unit_edges(np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 4]]))
    assert edges == pytest.approx(np.array([[1.0, 0, 0], [0, 0.6, 0.8]]))


@given(st.integers(0, 10_000))
def test_perpendicular_is_a_unit_vector_across(seed: int) -> None:
    direction = unit(np.random.default_rng(seed).normal(size=3))
    found = perpendicular(direction)
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-14)
    assert found @ direction == pytest.approx(0.0, abs=1e-14)
    assert found.max() == pytest.approx(np.sqrt(1.0 - (direction**2).min()))


@pytest.mark.parametrize(
    ("direction", "expected"),
    [([0, 0, 1], [1, 0, 0]), ([1, 0, 0], [0, 1, 0]), ([1e-12, 0, 1], [1, 0, 0]), ([0, 0, -1], [1, 0, 0])],
)
def test_perpendicular_of_an_axis_is_the_next_axis(direction: list[float], expected: list[float]) -> None:
    assert perpendicular(unit(direction)) == pytest.approx(expected, abs=1e-11)


def test_components_along_and_across_a_direction() -> None:
    along, across = along_and_across(np.array([[3.0, 4.0, -2.0], [0.0, 0.0, 5.0]]), np.eye(3)[[2, 2]])
    assert along == pytest.approx([-2.0, 5.0])
    assert across == pytest.approx([5.0, 0.0])


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 0.3, 0.5 * np.pi, 3.0, np.pi - 1e-8, np.pi])
def test_angle_between_is_accurate_from_zero_to_pi(angle: float) -> None:
    first = np.array([0.6, 0.0, 0.8])
    second = np.cos(angle) * first + np.sin(angle) * np.array([0.0, 1.0, 0.0])
    assert angles_between(first, second) == pytest.approx(angle, rel=1e-14, abs=1e-15)
    both = angles_between(np.stack([first, second]), np.stack([first, first]))
    assert both == pytest.approx([0.0, angle], rel=1e-14, abs=1e-15)
