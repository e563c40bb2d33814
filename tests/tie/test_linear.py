import numpy as np
import pytest

from knotfem.tie import make_path


def test_bowline_collapses_on_the_way(bowline):
    told = make_path("linear", bowline).describe()
    assert told["min_stretch"] == pytest.approx(0.018, abs=1e-3)
    assert told["max_stretch"] == pytest.approx(1.0, abs=1e-9)


def test_best_direction_halves_the_compression(bowline):
    assert make_path("linear", bowline, direction="best").describe()["min_stretch"] == pytest.approx(0.45, abs=0.01)


@pytest.mark.parametrize("degrees", [30.0, 90.0, 170.0])
def test_half_way_stretch_is_the_cosine_of_half_the_turn(degrees):
    angle = np.radians(degrees)
    target = np.arange(5)[:, None] * np.array([np.sin(angle), 0.0, np.cos(angle)])
    path = make_path("linear", target)
    np.testing.assert_allclose(path.stretch(0.5), np.cos(angle / 2.0), rtol=1e-12)
    assert path.describe()["min_stretch"] == pytest.approx(np.cos(angle / 2.0), rel=1e-12)
