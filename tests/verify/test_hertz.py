import numpy as np
import pytest

from knotfem.contact.law import Penalty
from knotfem.verify.benchmarks.hertz import RADIUS, YOUNGS, Crossing, half_space, sector


def test_half_space_sinks_by_half_the_approach_under_the_pressure():
    """Hertz: on the axis just below the surface u = pi p0 a / (2 E'), E' = E / (1 - nu^2) of one body."""
    a, force = 0.67, 0.1275
    peak, modulus = 1.5 * force / (np.pi * a**2), YOUNGS / 0.75
    deep = half_space(np.array([[0.0, 0.0, 0.3]]), force, a)[0, 2]
    z = 0.3 / a
    exact = peak * a / modulus * (0.5 * np.pi - np.arctan(z)) * (1.0 + z * z) - peak * z * a / modulus
    exact += 1.5 * peak * a / YOUNGS * z * (1.0 - z * np.arctan(1.0 / z))
    assert deep < np.pi * peak * a / (2.0 * modulus)
    assert deep == pytest.approx(exact, rel=0.2)


def test_half_space_is_a_point_force_far_away():
    point = np.array([[3.0, 0.0, 40.0]])
    u = half_space(point, 2.0, 0.5)[0]
    rho = np.linalg.norm(point)
    scale = 3.0 * 2.0 / (4.0 * np.pi * YOUNGS)
    assert u == pytest.approx([scale * 120.0 / rho**3, 0.0, scale * (1600.0 / rho**3 + 1.0 / rho)], rel=1e-3, abs=1e-9)


def test_sector_is_part_of_the_disc():
    section = sector(48, 6)
    corners = section.points[section.quads]
    edges = np.roll(corners, -1, axis=1) - corners
    before = np.roll(edges, 1, axis=1)
    assert (before[..., 0] * edges[..., 1] - before[..., 1] * edges[..., 0]).min() > 0.0
    assert np.hypot(*section.points[section.ring].T) == pytest.approx(1.0)
    assert np.abs(np.arctan2(*corners.mean(axis=1).T[::-1])).max() < np.pi / 3.0


def test_rods_cross_and_touch_at_the_origin():
    crossing = Crossing(48, 4, 8, Penalty(50.0, 0.005), 0.5)
    lower, upper = crossing.X[: crossing.count], crossing.X[crossing.count :]
    assert lower[:, 2].max() == pytest.approx(0.0, abs=1e-12)
    assert upper[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert np.hypot(lower[:, 0], lower[:, 2] + RADIUS).max() == pytest.approx(RADIUS)
    assert np.hypot(upper[:, 1], upper[:, 2] - RADIUS).max() == pytest.approx(RADIUS)
    held = np.zeros(len(crossing.X), dtype=bool)
    held[crossing.held] = True
    near = np.linalg.norm(crossing.X, axis=1) < 1.0
    assert not held[near].any()
    assert held.sum() > 0.5 * held.size
