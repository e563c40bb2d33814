import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.tie.extremes import deviation, edges_at, extreme_stretches, stationary_times


@given(seed=st.integers(0, 10**6), size=st.sampled_from([0.0, 1e-9, 1.0, 30.0]))
@settings(max_examples=60, deadline=None)
def test_nothing_on_a_dense_grid_is_longer_or_shorter(seed, size):
    rng = np.random.default_rng(seed)
    start, end, bump = rng.normal(size=3), rng.normal(size=(20, 3)), size * rng.normal(size=(20, 3))
    stretches = extreme_stretches(start, end, bump)[1]
    grid = np.tile(np.linspace(0.0, 1.0, 2001), (20, 1))
    dense = np.linalg.norm(edges_at(start, end, bump, grid), axis=2)
    slack = 1e-12 * (1.0 + size)
    assert (stretches.min(axis=1) <= dense.min(axis=1) + slack).all()
    assert (stretches.max(axis=1) >= dense.max(axis=1) - slack).all()
    np.testing.assert_allclose(stretches.max(axis=1), dense.max(axis=1), atol=1e-4 * (1.0 + size))


def test_edge_through_zero_is_found_to_the_last_digit():
    times, stretches = extreme_stretches(np.array([0.0, 0.0, 1.0]), np.array([[0.0, 0.0, -2.0]]), np.zeros((1, 3)))
    assert stretches.min() < 1e-15
    assert times[0, stretches[0].argmin()] == pytest.approx(1.0 / 3.0, abs=1e-15)


def test_three_turning_points_of_one_edge():
    start, end = np.array([1.0, 0.0, 0.0]), np.array([[-1.0, 0.0, 0.0]])
    bump = np.array([[0.0, 8.0, 0.0]])
    inner = np.sort(stationary_times(start, end, bump)[0, 2:])
    expected = 0.5 + np.array([-1.0, 0.0, 1.0]) * np.sqrt(0.25 - 1.0 / 32.0)
    np.testing.assert_allclose(inner, expected, atol=1e-14)


def test_all_roots_of_the_slope_are_found():
    rng = np.random.default_rng(11)
    start = np.array([1.0, 0.0, 0.0])
    end = rng.normal(size=(300, 3)) + np.array([-1.0, 0.0, 0.0])
    bump = rng.normal(size=(300, 3)) + np.array([0.0, 5.0, 0.0])
    found = stationary_times(start, end, bump)
    linear, square = end - start + bump, -bump
    counts = []
    for i in range(300):
        quartic = np.zeros(5)
        for a in range(3):
            part = [square[i, a], linear[i, a], start[a]]
            quartic = quartic + np.convolve(part, part)
        roots = np.roots(np.polyder(quartic))
        real = np.sort(roots[(abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)].real)
        inner = found[i, 2:]
        np.testing.assert_allclose(np.sort(inner[inner < 1.0]), real, atol=1e-9)
        counts.append(len(real))
    assert set(counts) == {0, 1, 2, 3}


def test_deviation_counts_compression_and_extension():
    start, still = np.array([0.0, 0.0, 1.0]), np.zeros((2, 3))
    assert deviation(start, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.25]]), still) == pytest.approx(0.25)
    assert deviation(start, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.6]]), still) == pytest.approx(0.4)
