import numpy as np
import pytest

from knotfem.geometry.segments import segment_distance


@pytest.mark.parametrize(
    ("c", "d", "distance"),
    [
        ([0.5, -1, 2], [0.5, 1, 2], 2.0),
        ([2, 0, 0], [3, 0, 0], 1.0),
        ([0.2, 1, 0], [0.7, 1, 0], 1.0),
        ([2, 1, 0], [2, 3, 0], np.sqrt(2.0)),
        ([0.5, 0, 3], [0.5, 0, 3], 3.0),
        ([-2, 0, 1], [-1, 0, 1], np.sqrt(2.0)),
    ],
)
def test_segment_distance(c: list[float], d: list[float], distance: float) -> None:
    a, b = np.zeros(3), np.array([1.0, 0, 0])
    c_, d_ = np.array(c, dtype=float), np.array(d, dtype=float)
    assert segment_distance(a, b, c_, d_) == pytest.approx(distance)
    assert segment_distance(d_, c_, a, b) == pytest.approx(distance)


def test_segment_distance_against_brute_force() -> None:
    random, s = np.random.default_rng(0), np.linspace(0.0, 1.0, 201)
    for _ in range(30):
        a, b, c, d = random.normal(size=(4, 3))
        p, q = a + s[:, None] * (b - a), c + s[:, None] * (d - c)
        brute = np.linalg.norm(p[:, None] - q[None], axis=2).min()
        assert segment_distance(a, b, c, d) == pytest.approx(brute, abs=0.02)
        assert segment_distance(a, b, c, d) <= brute + 1e-12
