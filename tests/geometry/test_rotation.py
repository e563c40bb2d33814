import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.geometry import rotation as rot

angles = st.floats(0.05, 2.6)
seeds = st.integers(0, 1000)


def pair(angle: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two directions at an angle, and a unit vector across the first."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=3)
    a /= np.linalg.norm(a)
    b = np.cross(a, rng.normal(size=3))
    b /= np.linalg.norm(b)
    turn = rng.uniform(0, 2 * np.pi)
    return a, np.cos(angle) * a + np.sin(angle) * b, np.cos(turn) * b + np.sin(turn) * np.cross(a, b)


@settings(deadline=None)
@given(angles, seeds)
def test_transport_is_the_smallest_rotation(angle, seed):
    a, b, v = pair(angle, seed)
    out = np.empty(3)
    rot.transport(a, b, v, out)
    axis = np.cross(a, b) / np.sin(angle)
    expected = np.cos(angle) * v + np.sin(angle) * np.cross(axis, v) + (1 - np.cos(angle)) * (axis @ v) * axis
    np.testing.assert_allclose(out, expected, atol=1e-12)


@settings(deadline=None)
@given(angles, seeds)
def test_carried_vector_spins_by_the_half_binormal(angle, seed):
    a, b, v = pair(angle, seed)
    rng = np.random.default_rng(seed + 1)
    da, db = np.cross(rng.normal(size=3), a), np.cross(rng.normal(size=3), b)
    k, out, moved, step = np.empty(3), np.empty(3), [], 1e-6
    rot.half_binormal(a, b, k)
    rot.transport(a, b, v, out)
    for sign in (1.0, -1.0):
        a2, b2 = a + sign * step * da, b + sign * step * db
        a2, b2 = a2 / np.linalg.norm(a2), b2 / np.linalg.norm(b2)
        start, end = np.empty(3), np.empty(3)
        rot.transport(a, a2, v, start)
        rot.transport(a2, b2, start, end)
        moved.append(end)
    spin = (moved[0] - moved[1]) @ np.cross(b, out) / (2 * step)
    assert spin == pytest.approx(-k @ (da + db), rel=1e-5, abs=1e-6)


@settings(deadline=None)
@given(angles, seeds)
def test_rate_of_the_half_binormal(angle, seed):
    a, b, _ = pair(angle, seed)
    rng = np.random.default_rng(seed + 2)
    da, db, step = rng.normal(size=3), rng.normal(size=3), 1e-6
    k, rate, ahead, behind = (np.empty(3) for _ in range(4))
    rot.half_binormal(a, b, k)
    rot.half_binormal_rate(a, b, k, da, db, rate)
    rot.half_binormal(a + step * da, b + step * db, ahead)
    rot.half_binormal(a - step * da, b - step * db, behind)
    np.testing.assert_allclose(rate, (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-5 * np.abs(rate).max())


@settings(deadline=None)
@given(st.floats(-50, 50), st.floats(-50, 50))
def test_nearest_turn(angle, reference):
    found = rot.nearest_turn(angle, reference)
    assert abs(found - reference) <= np.pi + 1e-9
    assert np.cos(found) == pytest.approx(np.cos(angle), abs=1e-9)
    assert np.sin(found) == pytest.approx(np.sin(angle), abs=1e-9)
