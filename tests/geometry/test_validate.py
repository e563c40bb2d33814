from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.geometry.curve import interpolate
from knotfem.geometry.resample import equal_chords
from knotfem.geometry.smoothing import laplacian
from knotfem.geometry.validate import LARGEST_CURVATURE, LARGEST_TURN, Cylinder, check_apart, check_centreline

Array = NDArray[np.float64]
POST = Cylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 20.0)


def circle_arc(radius: float, angle: float, nodes: int = 200) -> Array:
    a = np.linspace(0.0, angle, nodes)
    return radius * np.column_stack([np.cos(a), np.sin(a), 0 * a])


@pytest.mark.parametrize(
    "name",
    [
        "overhand",
        "figure_eight",
        "double_overhand",
        "cinquefoil",
        "granny",
        "square",
        "surgeon",
        "alpine_butterfly",
        "straight",
    ],
)
def test_shipped_knots_pass(shipped: Callable[[str], Array], name: str) -> None:
    assert check_centreline(shipped(name), 1.0) == []


@pytest.mark.parametrize("name", ["bowline", "clove_hitch", "two_half_hitches", "capstan_half", "capstan", "capstan_3"])
def test_shipped_hitches_pass(shipped: Callable[[str], Array], name: str) -> None:
    assert check_centreline(shipped(name), 6.0, obstacles=[POST]) == []


def refusal(points: object, diameter: float = 1.0, **options: object) -> str:
    with pytest.raises(InputError) as caught:
        check_centreline(points, diameter, **options)  # type: ignore[arg-type]
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_refuses_points_that_are_none() -> None:
    x = circle_arc(5.0, 3.0)
    assert "point 8 is not finite" in refusal(np.where(np.arange(200)[:, None] == 7, np.nan, x))
    assert "too few points; found 3; expected at least 4" in refusal(x[:3])
    assert "points 4 and 5 are the same" in refusal(np.insert(x, 3, x[3], axis=0))
    assert "rod diameter is not positive; found -1.0" in refusal(x, -1.0)


def test_refuses_a_closed_curve() -> None:
    assert "the curve is closed" in refusal(circle_arc(5.0, 2 * np.pi))
    assert "the curve is closed" in refusal(circle_arc(5.0, 2 * np.pi - 0.15))
    assert check_centreline(circle_arc(5.0, 2 * np.pi - 0.25), 1.0) == []


@pytest.mark.parametrize(("sharpness", "legal"), [(LARGEST_CURVATURE - 0.01, True), (LARGEST_CURVATURE + 0.01, False)])
def test_curvature_limit(sharpness: float, legal: bool) -> None:
    bend = circle_arc(1.0 / sharpness, 0.6 * np.pi, 61)
    if legal:
        assert check_centreline(bend, 1.0) == []
    else:
        assert "bends too sharply to be meshed at s/L = " in refusal(bend)


@pytest.mark.parametrize(("turn", "legal"), [(LARGEST_TURN - 0.01, True), (LARGEST_TURN + 0.01, False)])
def test_limit_of_the_turn_from_edge_to_edge(turn: float, legal: bool) -> None:
    bend = circle_arc(1.0, 4.0 * turn, 5)
    if legal:
        assert check_centreline(bend, 0.5) == []
    else:
        assert "edges are too long to follow the curve at s/L = " in refusal(bend, 0.5)


def test_refuses_a_rod_that_overlaps_or_crosses_itself(shipped: Callable[[str], Array]) -> None:
    x = shipped("overhand")
    assert check_centreline(x, 1.6) == []
    (warning,) = check_centreline(x, 1.7)
    assert warning.startswith("strands overlap by 0.0")
    assert warning.endswith("; contact separates them")
    assert "the rod overlaps itself at s/L = 0." in refusal(x, 1.9)
    a = np.linspace(-0.6 * np.pi, 1.2 * np.pi, 300)
    crossing = 10.0 * np.column_stack([np.sin(2 * a), np.sin(a), 0 * a])
    assert "the rod crosses itself at s/L = " in refusal(crossing)


def test_refuses_what_runs_into_an_obstacle(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    wider = POST._replace(diameter=31.0)
    assert "the rod overlaps obstacle 2 (gap between their surfaces); found -0.6" in refusal(
        x, 6.0, obstacles=[POST, wider]
    )
    aside = POST._replace(point=(12.0, 0.0, 0.0))
    assert "the rod runs inside obstacle 1" in refusal(x, 6.0, obstacles=[aside])


def test_touching_is_legal() -> None:
    x = np.column_stack([np.full(30, 13.0), np.zeros(30), np.linspace(-50, 50, 30)])
    assert check_centreline(x, 6.0, obstacles=[POST]) == []


def test_file_is_named() -> None:
    assert refusal(circle_arc(5.0, 2 * np.pi), file=Path("ring.csv")).startswith("ring.csv: the curve is closed")


def smoothed(x: Array, gamma: float, iterations: int, length: float) -> Array:
    return equal_chords(interpolate(laplacian(x, gamma, iterations)), len(x) - 1, length).points


def test_smoothing_that_leaves_room_is_silent(shipped: Callable[[str], Array]) -> None:
    x = shipped("bowline")
    assert check_centreline(smoothed(x, 0.1, 1000, 600.0), 6.0, unsmoothed=x, obstacles=[]) == []


def test_smoothing_that_brings_strands_close_is_a_warning(shipped: Callable[[str], Array]) -> None:
    x = equal_chords(interpolate(shipped("granny")), 600, 600.0).points
    (warning,) = check_centreline(smoothed(x, 0.1, 1000, 600.0), 600.0 / 124.0, unsmoothed=x)
    assert warning.startswith("smoothing has brought strands from 1.68 to 1.01 diameters apart at s/L = 0.")
    assert "overlap" not in warning


def test_an_overlap_is_judged_after_smoothing(shipped: Callable[[str], Array]) -> None:
    """Be it smoothing that made it, or smoothing that left it."""
    x = equal_chords(interpolate(shipped("surgeon")), 600, 600.0).points
    after = smoothed(x, 0.1, 1000, 600.0)
    (warning,) = check_centreline(after, 2.5, unsmoothed=x)
    assert warning.startswith("strands overlap by 0.137 mm (5.5 % of the diameter) at s/L = 0.")
    assert warning.endswith("; 2.64 diameters apart before smoothing; contact separates them")
    said = refusal(after, 600.0 / 152.0, unsmoothed=x)
    assert "overlaps itself" in said
    assert "after smoothing; 1.67 diameters apart before smoothing; found 2.363 mm" in said


def test_an_overlap_of_points_that_scatter_is_refused_unless_they_are_smoothed(shipped: Callable[[str], Array]) -> None:
    x = shipped("overhand")
    assert "the points scatter by about 0.02 mm" in refusal(x, 1.7, scatter=0.02)
    assert check_centreline(x, 1.6, scatter=0.02) == []
    (warning,) = check_centreline(x, 1.7, scatter=0.02, unsmoothed=x)
    assert "contact separates them" in warning


def test_rods_must_not_overlap_each_other():
    """Unlike diameters; a rod that begins pressed on another by less than a tenth is warned of."""
    x = np.linspace(-30.0, 30.0, 31)
    along = np.stack([x, 0.0 * x, 0.0 * x], axis=1)

    def across(height: float) -> np.ndarray:
        return np.stack([0.0 * x, x + 7.0, 0.0 * x + height], axis=1)

    assert check_apart([along, across(5.0)], [6.0, 4.0], ["a", "b"]) == []
    (warning,) = check_apart([along, across(4.8)], [6.0, 4.0], ["a", "b"])
    assert warning.startswith("b and a overlap by 0.2 mm")
    with pytest.raises(InputError, match=r"rods\.1: the rod overlaps a.*found 2 mm; expected at least 5 mm"):
        check_apart([along, across(2.0)], [6.0, 4.0], ["a", "b"])
