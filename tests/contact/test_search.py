"""Search for pairs on both kinds of surface; a station may have any number of neighbours."""

import numpy as np
import pytest
from specimens import make_rod, surfaces

from knotfem.contact.curve import make_samples
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.contact.search import _find_candidates, find_pairs, grown, match_pairs
from knotfem.contact.stations import make_stations
from knotfem.geometry.slices import Slices, equal_slices
from knotfem.mesh.rod_layout import make_layout

WAVES = 80
"""Local minima of the distance of the wavy rod from the straight one; once there was room for 64."""


def wavy_ring(radius: float, ripple: float) -> np.ndarray:
    """A ring about the z axis whose nodes lie inside and outside of it in turn, not quite closed."""
    nodes = 2 * WAVES + 1
    angle = np.linspace(0.02, 2.0 * np.pi - 0.02, nodes)
    distance = radius + ripple * (-1.0) ** np.arange(nodes)
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), 0.0 * angle], axis=1)


@pytest.fixture
def ringed():
    """A straight rod in the middle of a wavy ring, which it all but touches all round."""
    ring = wavy_ring(2.05, 0.04)
    spacing = float(np.linalg.norm(np.diff(ring, axis=0), axis=1).mean())
    layout = make_layout([4, 2 * WAVES], [1.0, spacing], [1.0, 1.0])
    x = np.zeros((layout.nodes, 4))
    x[layout.of(0), 2] = np.arange(5) - 2.0
    x[layout.of(1), :3] = ring
    return layout, x


def minima_by_hand(layout, x: np.ndarray, point: np.ndarray, cutoff: float) -> np.ndarray:
    """Coordinates of all local minima of the distance of a point to the ring's curve with a gap below the cutoff."""
    nodes = x[layout.of(1), :3]
    u = np.arange(1.0, len(nodes) - 1.6, 1e-2)
    middle = np.floor(u + 0.5).astype(int)
    t = (u - middle)[:, None]
    curve = 0.5 * (0.5 - t) ** 2 * nodes[middle - 1] + (0.75 - t * t) * nodes[middle]
    curve += 0.5 * (0.5 + t) ** 2 * nodes[middle + 1]
    distance = np.linalg.norm(curve - point, axis=1)
    inner = np.flatnonzero((distance[1:-1] < distance[:-2]) & (distance[1:-1] <= distance[2:])) + 1
    return u[inner[distance[inner] < 2.0 + cutoff]]


def test_no_candidate_is_dropped_however_many_a_station_has(ringed):
    layout, x = ringed
    stations = CurveSurface(layout).stations
    out = np.empty((1000, 3), dtype=np.int64)
    count = _find_candidates(x, stations, 0.5, 3.2, out)
    middle = out[:count][(out[:count, 0] == 2) & (out[:count, 1] == 1)]
    np.testing.assert_array_equal(middle[:, 2], np.arange(1, 2 * WAVES, 2))
    assert len(middle) == WAVES > 64


def test_room_for_candidates_grows(ringed):
    """The count says how much room there must be; what is there is right before it is enough."""
    layout, x = ringed
    stations = CurveSurface(layout).stations
    whole, part = np.empty((1000, 3), dtype=np.int64), np.full((70, 3), -1)
    count = _find_candidates(x, stations, 0.5, 3.2, whole)
    assert _find_candidates(x, stations, 0.5, 3.2, part) == count > 70
    np.testing.assert_array_equal(part, whole[:70])


def test_every_closest_point_of_a_sample_is_a_pair(ringed):
    layout, x = ringed
    surface, samples, cutoff = CurveSurface(layout), make_samples(layout, 0.25), 0.5
    points = samples.places(x)
    found, at = find_pairs(x, surface, samples.view, samples.start, points, cutoff)
    most = 0
    for s in np.flatnonzero((samples.rod == 0) & (np.abs(points[:, 2]) < 0.5)):
        expected = minima_by_hand(layout, x, points[s], cutoff)
        mine = at[(found[:, 0] == s) & (found[:, 1] == 1), 0]
        inside = mine[(mine > 1.5) & (mine < 2 * WAVES - 1.5)]
        wanted = expected[(expected > 1.5) & (expected < 2 * WAVES - 1.5)]
        np.testing.assert_allclose(inside, wanted, atol=0.02)
        most = max(most, mine.size)
    assert most > 64


def test_contact_on_all_sides_has_no_resultant(ringed):
    """All of the pairs carry force; with some of them dropped, one side of the ring would push alone."""
    layout, x = ringed
    contact = PairContact(CurveSurface(layout), make_samples(layout, 0.25), Penalty(1.0, 0.2))
    contact.update(x)
    residual = np.zeros_like(x)
    contact.assemble(x, residual, None)
    pairs = contact.pairs
    on = (contact.samples.rod[pairs.sample] == 0) & (pairs.force > 0.0)
    assert np.bincount(pairs.sample[on]).max() > 64
    pushed = np.abs(pairs.force[on]).sum()
    assert pushed > 0.1
    assert np.abs(residual[layout.of(0), :2].sum(axis=0)).max() < 0.03 * pushed


def test_tubes_are_searched_by_the_same_loop():
    """Rings of a hexahedral rod, thrown about so that its axis waves around a section of another one."""
    straight = make_rod(4.0, 4, section=4, radius=1.0)
    ring = wavy_ring(2.05, 0.04)
    wavy = make_rod(13.0, 2 * WAVES, section=4, radius=1.0, first=len(straight.mesh.nodes))
    x = np.vstack([straight.mesh.nodes - [0.0, 0.0, 2.0], wavy.mesh.nodes])
    x[wavy.axis] = ring
    surface, _ = surfaces([straight, wavy], 0.5)
    out = np.empty((5000, 3), dtype=np.int64)
    count = _find_candidates(x, surface.stations, 0.5, 3.2, out)
    middle = out[:count][(out[:count, 0] == 2) & (out[:count, 1] == 1)]
    np.testing.assert_array_equal(middle[:, 2], np.arange(1, 2 * WAVES, 2))


def test_stations_far_away_are_passed_over_but_none_within_reach():
    """Against all distances: a rod that comes near, goes far away and comes back at its very end."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        s = np.linspace(0.0, 6.0 * np.pi, 120)
        path = np.stack([s + 4.0 * np.sin(s), 12.0 * np.cos(0.7 * s), 3.0 * np.sin(1.3 * s)], axis=1)
        path += 0.4 * rng.standard_normal(path.shape)
        other = path[60] + np.array([0.5, 0.5, 0.5]) + np.outer(np.linspace(-4.0, 4.0, 9), rng.standard_normal(3))
        x = np.vstack([path, other])
        slices = [Slices(rng.uniform(0.3, 0.5, 119)), equal_slices(8.0, 8)]
        stations = make_stations(np.arange(129), slices, [0.6, 0.5])
        out = np.empty((2000, 3), dtype=np.int64)
        count = _find_candidates(x, stations, 0.3, 3.2, out)
        found = {tuple(row) for row in out[:count].tolist()}
        expected = set()
        for own, rod in ((0, 0), (0, 1), (1, 0), (1, 1)):
            reach = stations.radius[own] + stations.radius[rod] + 0.3 + stations.longest[own] + stations.longest[rod]
            first, last = stations.first[rod], stations.first[rod + 1]
            for i in range(stations.first[own], stations.first[own + 1]):
                distance = np.linalg.norm(x[first:last] - x[i], axis=1)
                if own == rod:
                    arc = stations.arclength[first:last] - stations.arclength[i]
                    near = np.abs(arc) <= 3.2 * stations.radius[own]
                    distance[near] = np.inf
                padded = np.concatenate([[np.inf], distance, [np.inf]])
                least = (distance < reach) & (distance <= padded[:-2]) & (distance < padded[2:])
                expected |= {(i, rod, int(j)) for j in np.flatnonzero(least)}
        assert len(expected) > 9
        assert found == expected


def test_arrays_grow_until_they_hold_all():
    asked = []

    def fill(capacity: int):
        asked.append(capacity)
        out = np.full(capacity, -1)
        out[: min(capacity, 7)] = np.arange(min(capacity, 7))
        return 7, (out, 2 * out)

    first, second = grown(fill, 3)
    assert asked == [3, 7]
    np.testing.assert_array_equal(first, np.arange(7))
    np.testing.assert_array_equal(second, 2 * np.arange(7))
    short, _ = grown(fill, 20)
    assert short.size == 7


def test_pairs_of_other_samples_and_rods_are_not_taken_for_old_ones():
    old, new = np.array([[0, 1], [1, 0], [1, 1], [3, 1]]), np.array([[0, 0], [1, 0], [1, 1], [2, 1], [3, 1]])
    match = np.empty(5, dtype=np.int64)
    match_pairs(old, np.array([2.0, 2.0, 2.0, 9.0]), new, np.full(5, 2.4), np.array([1.0, 1.0]), match)
    np.testing.assert_array_equal(match, [-1, 1, 2, -1, -1])
