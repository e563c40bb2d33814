"""Which strand wraps others, and which one runs."""

import numpy as np
import pytest
from shapes import D, Line, line, place_on, report, ring, straight, wound

from knotfem.stability.crossings import Crossing
from knotfem.stability.slip import SlipMeter, Tracks, UnitSlip
from knotfem.stability.unit import LockingUnit, locking_unit


@pytest.mark.parametrize("turns", [0.75, 1.0, 1.5])
def test_a_ring_wraps_a_straight_strand(turns):
    lines, crossings = wound(turns, 7)
    unit = locking_unit(crossings, lines, D)
    assert unit is not None
    assert unit.wrapping.rod == 0
    assert unit.angle == pytest.approx(2.0 * np.pi * turns, rel=0.05)
    assert [strand.rod for strand in unit.central] == [1]
    assert unit.pairs == tuple((k, True) for k in range(7))


def test_a_strand_that_only_leans_on_another_wraps_nothing():
    lines, crossings = wound(0.25, 3)
    assert locking_unit(crossings, lines, D) is None


def test_crossed_straight_strands_wrap_nothing():
    other = line(straight().points[:, [2, 1, 0]] + [0.0, D, 0.0])
    crossings = [Crossing((0, 1), (60.0, 60.0), (0.0, 0.0), 1.0, 1.0)]
    assert locking_unit(crossings, [straight(), other], D) is None


def test_a_rod_about_an_obstacle_wraps_it_where_no_strand_is_wrapped():
    found = ring(0.5)
    places = [place_on(found, p) for p in ([D, 0, 0], [0, D, 0.25 * D], [-D, 0, 0.5 * D])]
    crossings = [Crossing((0, -1), (s, np.nan), (0.0, 0.0), 1.0, 1.0) for s in places]
    unit = locking_unit(crossings, [found], D)
    assert unit is not None
    assert unit.central == ()
    assert unit.angle == pytest.approx(np.pi, rel=0.1)


def one_rod(turns: float = 1.0) -> tuple[list[Line], list[Crossing]]:
    """A rod whose first part winds about its last part; the loop meets itself, too."""
    lines, crossings = wound(turns, 5)
    first, last = lines
    points = np.concatenate([first.points, [[80.0, 80.0, 0.0], [80.0, 80.0, -90.0]], last.points])
    joined = line(points)
    shift = float(joined.arclengths[len(first.points) + 2])
    own = [Crossing((0, 0), (c.places[0], c.places[1] + shift), c.extents, 1.0, 1.0) for c in crossings]
    closing = Crossing((0, 0), (own[0].places[0] - 8.0, own[-1].places[0] + 8.0), (0.0, 0.0), 1.0, 1.0)
    return [joined], [*own, closing]


def test_where_a_loop_meets_itself_it_is_not_its_own_central_strand():
    lines, crossings = one_rod()
    unit = locking_unit(crossings, lines, D)
    assert unit is not None
    assert len(unit.pairs) == 5
    assert all(strand.first > unit.wrapping.last + 50.0 for strand in unit.central)


def slipped(wrapping: float, central: float) -> UnitSlip:
    """Slips of a unit whose crossings move by so much along either strand."""
    lines, crossings = wound(1.0, 5)
    tracks = Tracks(locking_unit(crossings, lines, D), crossings)
    for _ in range(2):
        tracks.follow(range(5), np.tile([0.5 * wrapping, 0.5 * central], (5, 1)))
    found = tracks.unit_slip
    assert found is not None
    return found


@pytest.mark.parametrize(("wrapping", "central", "mode"), [(3.0, 1.0, "wrapping"), (0.5, -4.0, "central")])
def test_the_strand_that_runs_further_is_the_mode(wrapping, central, mode):
    found = slipped(wrapping, central)
    assert found.mode == mode
    assert found.wrapping.slip == pytest.approx(wrapping)
    assert [strand.slip for strand in found.central] == pytest.approx([central])
    assert UnitSlip.restored(found.state()) == found


def test_a_lost_crossing_keeps_what_it_has_slipped():
    lines, crossings = wound(1.0, 5)
    tracks = Tracks(locking_unit(crossings, lines, D), crossings)
    tracks.follow([0, 1, 2, 3, -1], np.full((5, 2), 2.0))
    tracks.follow([0, 1, 2, 3], np.full((4, 2), 2.0))
    assert tracks.slips[:, 0] == pytest.approx([4.0, 4.0, 4.0, 4.0, 2.0])


def test_a_meter_goes_on_from_its_state():
    lines, _ = wound(1.0, 5)
    meter, other = SlipMeter(2, D), SlipMeter(2, D)
    meter.update(report([(0, 70.0, 1, 60.0), (0, 85.0, 1, 62.0)]))
    meter.begin_step(lines)
    meter.update(report([(0, 72.0, 1, 60.5), (0, 87.0, 1, 62.5)]))
    other.restore(meter.state())
    for m in (meter, other):
        m.update(report([(0, 75.0, 1, 61.0), (0, 90.0, 1, 63.0)]))
    np.testing.assert_array_equal(other.through, meter.through)
    np.testing.assert_array_equal(other.since_step.slips, meter.since_step.slips)
    assert meter.through == pytest.approx([5.0, 1.0])


def test_a_unit_goes_through_a_checkpoint():
    lines, crossings = wound(1.0, 5)
    unit = locking_unit(crossings, lines, D)
    assert unit is not None
    assert LockingUnit.restored(unit.state()) == unit
