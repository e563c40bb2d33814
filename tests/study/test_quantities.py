"""Knot size and scales against shapes that are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem.study.quantities import GRID, bent_length, main_quantity, scale_of


@given(st.floats(5.0, 50.0), st.floats(0.5, 3.0), st.integers(200, 400))
def test_bent_length_of_an_arc_between_straight_ends(radius, angle, count):
    arc, tail = radius * angle, 40.0
    s = np.linspace(-tail, arc + tail, count)
    phi = np.clip(s, 0.0, arc) / radius
    beyond, before = np.maximum(s - arc, 0.0), np.minimum(s, 0.0)
    x = radius * np.sin(phi) + beyond * np.cos(angle) + before
    y = radius * (1.0 - np.cos(phi)) + beyond * np.sin(angle)
    points = np.stack([x, y, np.zeros(count)], axis=1)
    assert bent_length(points) == pytest.approx(arc, abs=2.0 * (s[1] - s[0]))


def test_bent_length_does_not_depend_on_place_and_orientation():
    t = np.linspace(0.0, 6.0, 300)
    helix = np.stack([np.cos(t), np.sin(t), 0.3 * t], axis=1)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    assert bent_length(helix @ turn.T + 7.0) == pytest.approx(bent_length(helix))


def test_straight_line_is_not_bent():
    assert bent_length(np.linspace([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], 20)) == 0.0


def test_scales():
    assert scale_of("force", np.array([3.0, 4.0])) == pytest.approx(np.sqrt(12.5))
    assert scale_of("penetration", np.array([0.02])) == 1.0
    line = np.stack([np.linspace(-1.0, 1.0, GRID), np.zeros(GRID), np.zeros(GRID)])
    moved = line + np.array([5.0, -2.0, 1.0])[:, None]
    assert scale_of("shape", line.ravel()) == pytest.approx(1.0 / 3.0, rel=0.02)
    assert scale_of("shape", moved.ravel()) == pytest.approx(scale_of("shape", line.ravel()))


def test_runs_are_ranked_by_force_where_there_is_one():
    assert main_quantity(["tension", "force", "shape"]) == "force"
    assert main_quantity(["tension", "shape", "sag"]) == "sag"
    assert main_quantity(["tension", "shape"]) == "shape"
