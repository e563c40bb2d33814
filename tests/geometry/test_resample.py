from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry import resample
from knotfem.geometry.curve import interpolate
from knotfem.geometry.measures import arclength, curvature
from knotfem.geometry.nurbs import Nurbs, blender_knots
from knotfem.geometry.resample import arc_parameters, equal_chords

Array = NDArray[np.float64]
BEND = np.array([[0.0, 0, 0], [10, 0, 0], [12, 1, 0], [12, 3, 0], [10, 4, 0], [0, 4, 0]])


def deviation(points: Array) -> float:
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return float(np.abs(chords / chords.mean() - 1.0).max())


def circle(points: int) -> Array:
    angle = np.linspace(0.0, 1.9 * np.pi, points)
    return 5.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])


def test_chords_are_equal_and_their_sum_is_the_length() -> None:
    curve = interpolate(circle(40))
    found = equal_chords(curve, 60, 600.0)
    assert deviation(found.points) < 1e-11
    assert np.linalg.norm(np.diff(found.points, axis=0), axis=1).sum() == pytest.approx(600.0, rel=1e-12)
    assert found.points == pytest.approx(found.scale * curve(found.parameters))
    assert found.points[[0, -1]] == pytest.approx(found.scale * curve(np.array(curve.domain)))


def test_scale_is_one_when_no_length_is_asked_for() -> None:
    found = equal_chords(interpolate(circle(40)), 30)
    assert found.scale == 1.0
    assert found.points[0] == pytest.approx([5.0, 0.0, 0.0])


def test_equal_arcs_would_strain_the_core() -> None:
    curve = interpolate(BEND)
    arcs = curve(arc_parameters(curve, 31))
    assert deviation(arcs) > 1e-3
    assert deviation(equal_chords(curve, 30).points) < 1e-11


@pytest.mark.parametrize("edges", [5, 6, 7, 9, 12])
def test_few_long_chords_converge_quadratically(edges: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resample, "MOST_ITERATIONS", 5)
    assert deviation(equal_chords(interpolate(BEND), edges).points) < 1e-9


def test_works_on_nurbs_with_uneven_weights() -> None:
    random = np.random.default_rng(5)
    curve = Nurbs(
        3, random.normal(size=(9, 3)), random.uniform(0.3, 3.0, 9), blender_knots(9, 4, endpoint=True, bezier=False)
    )
    assert deviation(equal_chords(curve, 200, 100.0).points) < 1e-9


def test_arc_parameters_divide_the_length_evenly() -> None:
    curve = interpolate(np.array([[0.0, 0, 0], [1, 0, 0], [4, 1, 0], [5, 5, 2]]))
    fine = curve(arc_parameters(curve, 20001))
    chords = np.linalg.norm(np.diff(fine, axis=0), axis=1)
    assert chords == pytest.approx(np.full(20000, chords.mean()), rel=1e-3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 7), st.integers(300, 700))
def test_any_smooth_curve(random_curve: Callable[..., Array], seed: int, modes: int, edges: int) -> None:
    curve = interpolate(random_curve(seed, modes, 60))
    fine = curve(arc_parameters(curve, 8 * edges + 1))
    assume(curvature(fine).max() * arclength(fine)[-1] < 3.0 * edges)
    found = equal_chords(curve, edges, 600.0)
    assert deviation(found.points) < 1e-9
    assert (np.diff(found.parameters) > 0.0).all()


@pytest.mark.parametrize(
    ("edges", "length", "message"),
    [(0, 1.0, "too few edges"), (5, 0.0, "length is not positive"), (5, float("nan"), "length is not positive")],
)
def test_refuses(edges: int, length: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        equal_chords(interpolate(circle(10)), edges, length)


def test_refuses_a_bend_far_tighter_than_a_chord(random_curve: Callable[..., Array]) -> None:
    with pytest.raises(InputError, match="no 516 equal chords: it turns too sharply"):
        equal_chords(interpolate(random_curve(168, 6, 60)), 516)


def test_refuses_a_curve_without_equal_chords() -> None:
    closed = interpolate(np.vstack([circle(40)[:-1], [[5.0, 0.0, 0.0]]]))
    with pytest.raises(InputError, match="no 1 equal chords"):
        equal_chords(closed, 1)
