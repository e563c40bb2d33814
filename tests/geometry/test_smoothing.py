import math

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.geometry.smoothing import gaussian_width, laplacian


def test_one_pass_is_the_formula() -> None:
    x = np.random.default_rng(0).normal(size=(7, 3))
    smoothed = laplacian(x, 0.3, 1)
    for i in range(1, 6):
        assert smoothed[i] == pytest.approx(x[i] - 0.3 * (x[i] - 0.5 * (x[i - 1] + x[i + 1])))
    assert np.array_equal(smoothed[[0, -1]], x[[0, -1]])


def test_waves_decay_at_their_exact_rate() -> None:
    n, k, gamma, passes = 100, 9, 0.1, 1000
    wave = np.sin(np.pi * k * np.arange(n + 1) / n)
    x = np.column_stack([np.arange(n + 1.0), wave, np.zeros(n + 1)])
    factor = (1.0 - gamma * (1.0 - math.cos(math.pi * k / n))) ** passes
    assert laplacian(x, gamma, passes)[:, 1] == pytest.approx(factor * wave, abs=1e-12)


def test_a_spike_becomes_a_gaussian_of_the_stated_width() -> None:
    x = np.column_stack([np.arange(601.0), np.zeros(601), np.zeros(601)])
    x[300, 2] = 1.0
    bump = laplacian(x)[:, 2]
    spread = math.sqrt((bump * (x[:, 0] - 300.0) ** 2).sum() / bump.sum())
    assert gaussian_width(0.1, 1000, 1.0) == pytest.approx(10.0)
    assert spread == pytest.approx(10.0, rel=1e-6)
    assert bump[300] == pytest.approx(1.0 / (10.0 * math.sqrt(2.0 * math.pi)), rel=3e-3)


def test_no_pass_changes_nothing_and_the_input_is_left_alone() -> None:
    x = np.random.default_rng(0).normal(size=(7, 3))
    kept = x.copy()
    assert np.array_equal(laplacian(x, 0.1, 0), x)
    laplacian(x, 0.5, 3)
    assert np.array_equal(x, kept)


@pytest.mark.parametrize(("gamma", "iterations"), [(-0.1, 1), (1.1, 1), (math.nan, 1), (0.1, -1)])
def test_refuses(gamma: float, iterations: int) -> None:
    with pytest.raises(InputError, match=r"out of range|negative"):
        laplacian(np.eye(3), gamma, iterations)
