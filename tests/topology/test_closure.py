import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.topology.closure import FAR, close

Array = NDArray[np.float64]
ROD = np.column_stack([np.linspace(-1.0, 1.0, 5), np.zeros(5), [0.0, 0.1, 0.2, 0.1, 0.0]])


def test_keeps_the_rod_and_joins_far_away() -> None:
    polygon = close(ROD)
    assert polygon[: len(ROD)] == pytest.approx(ROD)
    around = np.vstack([polygon[len(ROD) :], polygon[len(ROD) :][:1]]) - [0, 0, 0.1]
    radius = np.linalg.norm(ROD - [0, 0, 0.1], axis=1).max()
    assert np.linalg.norm(around, axis=1) == pytest.approx(np.full(len(around), FAR * radius))
    middles = 0.5 * (around[1:-1] + around[:-2])
    assert np.linalg.norm(middles, axis=1).min() > 0.9 * FAR * radius


def test_ends_go_where_they_are_told() -> None:
    polygon = close(ROD, ("tangent", (0, 0, 2)))
    along = close(ROD)[len(ROD)] - ROD[-1]
    assert along / np.linalg.norm(along) == pytest.approx((ROD[-1] - ROD[-2]) / np.hypot(0.5, 0.1))
    last, first = polygon[len(ROD)] - ROD[-1], polygon[-1] - ROD[0]
    assert np.cross(first, ROD[0] - ROD[1]) == pytest.approx(np.zeros(3), abs=1e-12)
    assert first @ (ROD[0] - ROD[1]) > 0
    assert last[:2] == pytest.approx([0.0, 0.0])
    assert last[2] > 0
    outward = close(ROD, ("outward", "outward"))[len(ROD)] - ROD[-1]
    assert outward / np.linalg.norm(outward) == pytest.approx(np.array([1, 0, -0.1]) / np.hypot(1, 0.1))


@pytest.mark.parametrize("ends", [((0, 0, 1), (0, 0, 1)), ((0, 0, 1), (0, 0, -1)), ((1, 0, 0), (-1, 0, 0))])
def test_parallel_and_opposite_ends_close(ends: tuple) -> None:
    polygon = close(ROD, ends)
    assert np.isfinite(polygon).all()
    assert np.linalg.norm(np.diff(polygon, axis=0), axis=1).min() > 0


def test_ends_in_opposite_directions_are_joined_by_half_a_circle() -> None:
    joined = close(np.outer([-1.0, 0.0, 1.0], [0, 0, 1]))[3:]
    assert np.linalg.norm(joined, axis=1) == pytest.approx(np.full(len(joined), FAR))
    assert joined[[0, -1]] == pytest.approx(np.array([[0, 0, FAR], [0, 0, -FAR]]), abs=1e-12)
    assert np.linalg.norm(np.diff(joined, axis=0), axis=1) == pytest.approx(np.full(4, 2 * FAR * np.sin(np.pi / 8)))


def test_refuses_an_unknown_direction() -> None:
    with pytest.raises(InputError, match="unknown direction of an end; found upward"):
        close(ROD, ("tangent", "upward"))
    with pytest.raises(InputError, match="not a direction"):
        close(ROD, ("tangent", (0, 0, 0)))
