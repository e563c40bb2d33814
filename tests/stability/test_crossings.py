"""Samples in contact make crossings, and crossings are followed."""

import numpy as np
import pytest
from shapes import D, report

from knotfem.contact.report import ContactReport
from knotfem.stability.crossings import crossings_of, matched
from knotfem.stability.slip import SlipMeter


def samples(a: float, b: float, spread: float = 1.0):
    """A crossing at arclengths a and b of one rod, seen from both strands."""
    return [(0, a + e, 0, b - e) for e in (-spread, 0.0, spread)] + [(0, b - e, 0, a + e) for e in (-spread, spread)]


def test_no_contact_no_crossing():
    assert crossings_of(ContactReport.empty(), D) == []


def test_both_strands_samples_make_one_crossing():
    (found,) = crossings_of(report(samples(50.0, 200.0)), D)
    assert found.rods == (0, 0)
    assert found.places == pytest.approx((50.0, 200.0))
    assert found.extents == pytest.approx((2.0, 2.0))
    assert found.force == pytest.approx(5.0)
    assert not found.on_obstacle


def test_places_a_diameter_apart_are_two_crossings_and_obstacles_another():
    found = crossings_of(report([*samples(50.0, 200.0), *samples(50.0, 215.0), (0, 120.0, -1, np.nan)]), D)
    assert [c.rods for c in found] == [(0, 0), (0, 0), (0, -1)]
    assert found[2].on_obstacle


def test_rods_are_ordered():
    (found,) = crossings_of(report([(1, 30.0, 0, 80.0)]), D)
    assert (found.rods, found.places) == ((0, 1), (80.0, 30.0))


def test_a_crossing_is_followed_to_the_nearest_one():
    before = crossings_of(report([*samples(50.0, 200.0), *samples(60.0, 210.0)]), D)
    now = crossings_of(report([*samples(54.0, 203.0), *samples(64.0, 213.0), *samples(100.0, 300.0)]), D)
    assert matched(before, now, D) == [0, 1]
    assert matched(before, now, 2.0) == [-1, -1]


def test_what_runs_through_is_added_up_whatever_the_step():
    meter = SlipMeter(1, D)
    for step in range(11):
        meter.update(report([*samples(50.0 + 2.0 * step, 200.0 + 3.0 * step), (0, 120.0, -1, np.nan)]))
    assert meter.through == pytest.approx([25.0])


def test_only_a_rod_that_touches_no_strand_is_measured_on_obstacles():
    meter = SlipMeter(1, D)
    for step in range(5):
        meter.update(report([(0, 120.0 - step, -1, np.nan)]))
    assert meter.through == pytest.approx([-4.0])
