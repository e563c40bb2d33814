from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.geometry.clearance import close_strands, cylinder_clearance, rod_clearance, strand_clearance
from knotfem.geometry.measures import arclength, curvature, turning_angles
from knotfem.geometry.segments import segment_distance

Array = NDArray[np.float64]


def hairpin(width: float, legs: float, nodes: int = 200) -> Array:
    """Two parallel legs joined by a half circle."""
    a = np.linspace(-0.5 * np.pi, 0.5 * np.pi, nodes)
    bend = 0.5 * width * np.column_stack([np.cos(a), np.sin(a), 0 * a])
    leg = np.linspace(legs, 0.0, nodes)[:-1]
    lower = np.column_stack([-leg, np.full(nodes - 1, -0.5 * width), np.zeros(nodes - 1)])
    return np.vstack([lower, bend, lower[::-1] * [1, -1, 1]])


@pytest.mark.parametrize(
    ("name", "diameter", "closest", "sharpest"),
    [
        ("bowline", 6.0, 1.99, 0.50),
        ("bowline_arcs", 6.0, 1.5, 0.45),
        ("overhand", 1.0, 1.68, 0.31),
        ("granny", 1.0, 1.68, 0.32),
        ("surgeon", 1.0, 1.67, 0.40),
        ("alpine_butterfly", 1.0, 1.57, 0.42),
        ("two_half_hitches", 6.0, 1.56, 0.51),
        ("capstan_3", 6.0, 1.63, 0.42),
    ],
)
def test_shipped_curves(
    shipped: Callable[[str], Array], name: str, diameter: float, closest: float, sharpest: float
) -> None:
    x = shipped(name)
    assert strand_clearance(x, diameter).distance / diameter == pytest.approx(closest, abs=0.01)
    assert curvature(x).max() * diameter == pytest.approx(sharpest, abs=0.02)


@pytest.mark.parametrize("width", [1.2, 3.0])
def test_hairpin(width: float) -> None:
    found = strand_clearance(hairpin(width, 5.0), 1.0)
    assert found.distance == pytest.approx(width, rel=1e-3)


def test_clearance_finds_the_place_of_the_crossing() -> None:
    loop = np.array([[0.0, 0, 0], [10, 0, 0], [10, 5, 0], [5, 5, 0], [5, -5, 1.5]])
    found = strand_clearance(loop, 1.0)
    assert (found.i, found.j) == (0, 3)
    assert found.distance == pytest.approx(0.75 * 10 / np.hypot(10, 1.5))


def test_clearance_of_a_coarse_polyline_against_brute_force() -> None:
    for seed in range(20):
        x = np.random.default_rng(seed).normal(size=(12, 3)).cumsum(axis=0)
        turned, arc = np.append(0.0, turning_angles(x).cumsum()), arclength(x)
        brute = min(
            segment_distance(x[i], x[i + 1], x[j], x[j + 1])
            for i in range(11)
            for j in range(i + 2, 11)
            if turned[j] - turned[i] >= np.pi and arc[j] - arc[i + 1] >= 0.16
        )
        assert strand_clearance(x, 0.1).distance == pytest.approx(brute)


def test_one_strand_has_no_clearance() -> None:
    a = np.linspace(0.0, 3.0, 31)
    found = strand_clearance(np.column_stack([np.cos(a), np.sin(a), 0 * a]), 0.1)
    assert found == (np.inf, -1, -1)


def test_clearance_does_not_depend_on_place_or_scale(
    random_curve: Callable[..., Array], rigid: Callable[[int], tuple[Array, Array]]
) -> None:
    x, (rotation, shift) = random_curve(7), rigid(2)
    found = strand_clearance(x, 0.1)
    moved = strand_clearance(2.0 * x @ rotation.T + shift, 0.2)
    assert moved.distance == pytest.approx(2.0 * found.distance)
    assert moved[1:] == found[1:]


def test_rods_apart() -> None:
    x = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    y = np.column_stack([np.full(5, 2.3), np.arange(5.0) - 1.6, np.full(5, 1.7)])
    assert rod_clearance(x, y).distance == pytest.approx(1.7)
    assert rod_clearance(x, y)[1:] == (2, 1)


@pytest.mark.parametrize(
    ("name", "gap"),
    [("bowline", 4.85), ("clove_hitch", 2.0), ("two_half_hitches", 2.1), ("capstan_half", 1.9), ("capstan", 2.0)],
)
def test_cylinder_gap_of_shipped_curves(shipped: Callable[[str], Array], name: str, gap: float) -> None:
    assert cylinder_clearance(shipped(name), [0, 0, 0], [0, 1, 0], 20.0, 6.0) == pytest.approx(gap, abs=0.1)


def test_cylinder_gap_between_nodes() -> None:
    x = np.array([[-10.0, 5, 3], [10, 5, -3]])
    assert cylinder_clearance(x, [0, 0, 7], [0, 0, 2], 4.0, 1.0) == pytest.approx(2.5)
    assert cylinder_clearance(x, [1, 5, 0], [0, 0, 1], 4.0, 1.0) == pytest.approx(-2.5)


def test_close_strands_are_the_crossing_of_a_loop_without_its_tails() -> None:
    s = np.linspace(-1, 1, 401)[:, None]
    straight = np.hstack([100 * s, 0 * s, 0 * s])
    assert not close_strands(straight, 6.0).any()
    t = np.linspace(-3, 3, 601)
    loop = 20 * np.column_stack([t**3 - 3 * t, t**2, 0.2 * t])
    near = loop[close_strands(loop, 6.0)]
    assert len(near) > 4
    assert np.linalg.norm(near[:, :2] - [0.0, 60.0], axis=1).max() < 20
