"""Lengths of slices, and how they follow the curvature of a curve."""

import numpy as np
import pytest

from knotfem.geometry.curve import interpolate
from knotfem.geometry.grading import GROWTH, graded_slices
from knotfem.geometry.resample import chords, equal_chords
from knotfem.geometry.slices import Slices, equal_slices

STRAIGHT, R = 60.0, 8.0
LENGTH = 2.0 * STRAIGHT + np.pi * R
BEND = STRAIGHT, STRAIGHT + np.pi * R
"""Arclengths between which the hairpin is bent."""


def hairpin(count: int = 400) -> np.ndarray:
    """Two straight legs and half a circle between, points at equal arclengths."""
    s = np.linspace(0.0, LENGTH, count + 1)
    phi = np.clip((s - STRAIGHT) / R, 0.0, np.pi)
    leg = np.minimum(s, STRAIGHT) - np.maximum(s - BEND[1], 0.0)
    return np.stack([leg + R * np.sin(phi), R * (1.0 - np.cos(phi)), 0.0 * s], axis=1)


def test_equal_slices_are_counted():
    slices = equal_slices(7.0, 300)
    np.testing.assert_array_equal(slices.arclength, np.arange(301) * (7.0 / 300))
    np.testing.assert_array_equal(slices.fractions, np.arange(301) / 300)
    np.testing.assert_array_equal(slices.middles, (np.arange(300) + 0.5) / 300)
    values = np.random.default_rng(0).standard_normal((300, 3))
    np.testing.assert_array_equal(slices.at_sections(values)[1:-1], 0.5 * (values[1:] + values[:-1]))


def test_what_is_linear_along_the_rod_is_met_at_the_sections():
    slices = Slices(np.array([1.0, 2.0, 4.0, 3.0]))
    np.testing.assert_array_equal(slices.arclength, [0.0, 1.0, 3.0, 7.0, 10.0])
    np.testing.assert_allclose(slices.middles, [0.05, 0.2, 0.5, 0.85])
    found = slices.at_sections(np.stack([slices.middles, 1.0 - slices.middles], axis=1))
    np.testing.assert_allclose(found[1:-1, 0], slices.fractions[1:-1])
    np.testing.assert_allclose(found.sum(axis=1), 1.0)


@pytest.mark.parametrize("order", [1, 2])
def test_turning_angle_of_slices_is_bounded_near_bends(order):
    angle, longest, reach = 0.1, 4.0, 10.0
    slices = graded_slices(hairpin(), LENGTH, longest, angle, reach, order)
    lengths = slices.lengths
    assert slices.count % order == 0
    np.testing.assert_array_equal(lengths[::order], lengths[order - 1 :: order])
    assert slices.arclength[-1] == pytest.approx(LENGTH, rel=1e-12)
    assert lengths.max() < longest * (1.0 + 1e-9)
    near = (slices.arclength[:-1] > BEND[0] - reach) & (slices.arclength[1:] < BEND[1] + reach)
    assert lengths[near].max() <= angle * R * 1.01
    assert lengths[near].max() > 0.9 * angle * R
    assert lengths[[0, -1]].min() > 0.9 * longest


def test_lengths_grow_slowly_and_as_fast_as_they_may():
    slices = graded_slices(hairpin(), LENGTH, 4.0, 0.1, 10.0)
    growth = slices.lengths[1:] / slices.lengths[:-1]
    assert np.maximum(growth, 1.0 / growth).max() == pytest.approx(GROWTH, rel=0.01)
    assert 60 < slices.count < 0.6 * LENGTH / (0.1 * R)


def test_slices_of_a_circle_are_equal_and_of_a_line_the_longest():
    phi = np.linspace(0.0, 1.5 * np.pi, 300)
    circle = R * np.stack([np.cos(phi), np.sin(phi), 0.0 * phi], axis=1)
    lengths = graded_slices(circle, 3.0 * np.pi * R, 9.0, 0.25, 5.0).lengths  # of twice the radius when scaled
    np.testing.assert_allclose(lengths, 3.0 * np.pi * R / 19, rtol=1e-6)
    line = np.linspace([0.0, 0.0, 0.0], [30.0, 0.0, 0.0], 40)
    np.testing.assert_allclose(graded_slices(line, 30.0, 4.0, 0.1, 5.0).lengths, 3.75, rtol=1e-9)


def test_chords_are_as_long_as_the_slices():
    slices = graded_slices(hairpin(), 250.0, 4.0, 0.2, 10.0)
    curve = interpolate(hairpin())
    found = chords(curve, slices, 250.0)
    np.testing.assert_allclose(np.linalg.norm(np.diff(found.points, axis=0), axis=1), slices.lengths, rtol=1e-9)
    np.testing.assert_allclose(found.points[[0, -1]], found.scale * hairpin()[[0, -1]], atol=1e-12)
    equal = chords(curve, equal_slices(250.0, 60), 250.0)
    np.testing.assert_array_equal(equal.points, equal_chords(curve, 60, 250.0).points)
