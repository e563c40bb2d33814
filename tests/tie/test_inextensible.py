from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.tie import make_path


def turns(points: np.ndarray) -> np.ndarray:
    edges = np.diff(points, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    return np.linalg.norm(np.diff(edges, axis=0), axis=1)


def test_bowline_is_tied_without_stretch_or_extra_curvature(bowline):
    path = make_path("inextensible", bowline)
    times = np.linspace(0.0, 1.0, 41)
    states = [path.at(t) for t in times]
    assert max(np.abs(path.stretch(t) - 1.0).max() for t in times) < 1e-10
    assert max(turns(x).max() for x in states) <= turns(bowline).max() * (1.0 + 1e-9)
    assert max(np.linalg.norm(b - a, axis=1).max() for a, b in pairwise(states)) < 11.0
    assert path.describe()["largest_turn_rad"] / 40.0 < 0.06
    assert path.describe()["largest_curvature_over_target"] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", ["alpine_butterfly", "surgeon", "round_turn_two_half_hitches"])
def test_other_knots_too(name, knot):
    path = make_path("inextensible", knot(name, 300))
    assert path.describe()["max_stretch_deviation"] < 1e-10


def test_tangent_turns_evenly_along_its_great_circle():
    target = np.array([[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0.0]])
    path = make_path("inextensible", target, direction=(0.0, 0.0, 1.0))
    for t in (0.25, 0.5, 0.8):
        edges = np.diff(path.at(t), axis=0)
        np.testing.assert_allclose(edges[0], (0.0, 0.0, 1.0), atol=1e-14)
        np.testing.assert_allclose(edges[1], (0.0, np.sin(t * np.pi / 2), np.cos(t * np.pi / 2)), atol=1e-14)
        assert np.arccos(edges[2, 2]) == pytest.approx(t * np.pi)
        assert np.linalg.norm(edges[2]) == pytest.approx(1.0, abs=1e-14)  # opposite to the rod: any normal will do


def test_unequal_chords_deviate_no_further_than_the_target(bowline):
    points = bowline[np.r_[0:300, 300:601:2]]
    path = make_path("inextensible", points)
    own = np.abs(np.linalg.norm(np.diff(points, axis=0), axis=1) / path.slices.lengths - 1.0).max()
    assert own > 0.1
    assert path.describe()["max_stretch_deviation"] <= own + 1e-12


def test_rigid_motion_carries_the_path_along(bowline, rotation):
    shift = np.array([5.0, -70.0, 11.0])
    path = make_path("inextensible", bowline)
    moved = make_path("inextensible", bowline @ rotation.T + shift)
    for t in (0.0, 0.4, 1.0):
        np.testing.assert_allclose(moved.at(t), path.at(t) @ rotation.T + shift, atol=1e-8)


@given(seed=st.integers(0, 10**6), edges=st.integers(2, 60))
@settings(max_examples=40, deadline=None)
def test_any_polyline_of_equal_chords(seed, edges):
    tangents = np.random.default_rng(seed).normal(size=(edges, 3))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    target = np.concatenate([np.zeros((1, 3)), np.cumsum(tangents, axis=0)])
    path = make_path("inextensible", target)
    assert max(np.abs(path.stretch(t) - 1.0).max() for t in np.linspace(0.0, 1.0, 7)) < 1e-10
    assert np.array_equal(path.at(1.0), target)
