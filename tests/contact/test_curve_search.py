"""Pairs of samples and discrete rods: found, and known again."""

import numpy as np
from reduced import RADIUS, Rods, begun, contact, line, spec

from knotfem.contact.search import match_pairs
from knotfem.contact.surface import PairView


def looped(turns: float, pitch: float) -> np.ndarray:
    phi = np.linspace(0.0, 2.0 * np.pi * turns, int(40 * turns) + 1)
    return np.stack([15.0 * np.cos(phi), 15.0 * np.sin(phi), pitch * phi / (2.0 * np.pi)], axis=1)


def places(pairs: PairView, digits: int) -> list[tuple[int, float]]:
    """Sample of each pair and where the closest point is."""
    return [(int(s), round(u, digits)) for s, u in zip(pairs.sample, pairs.at[:, 0].tolist(), strict=True)]


def by_hand(model: Rods) -> set[tuple[int, int]]:
    """Pairs of samples and nearest whole segments, by looking at a fine polygon of the curve."""
    c, fine = model.contact, model.x[:, :3]
    found = set()
    for s, point in enumerate(c.points):
        distance = np.linalg.norm(fine - point, axis=1)
        own = c.samples.u[s]
        far = np.abs(np.arange(len(fine)) - own) > 8
        for j in np.flatnonzero(far[1:-1] & (distance[1:-1] <= distance[:-2]) & (distance[1:-1] < distance[2:])) + 1:
            if distance[j] < 2 * RADIUS + 0.3:
                found.add((s, int(j)))
    return found


def test_finds_all_pairs_of_a_close_wound_helix():
    model = begun(Rods([spec(looped(3.0, 2 * RADIUS))], contact()))
    expected, found = by_hand(model), set(places(model.contact.pairs, 0))
    assert len(expected) > 300
    for s, j in expected:
        assert {(s, j - 1), (s, j), (s, j + 1)} & found


def test_no_pair_twice():
    found = places(begun(Rods([spec(looped(3.0, 2 * RADIUS))], contact())).contact.pairs, 3)
    assert len(set(found)) == len(found)


def test_a_pair_keeps_its_memory_while_it_slides_on():
    above = np.array([0.0, 0.0, 2 * RADIUS - 0.1])
    model = begun(Rods([spec(line(20, 40.0)), spec(line(20, 40.0) + above)], contact(0.3)))
    contacts, friction = model.contact, model.friction

    def slips() -> dict[tuple[int, int], float]:
        pairs, stored = contacts.pairs, friction.view.stored[:, 0]
        return {(int(s), int(rod)): slip for s, rod, slip in zip(pairs.sample, pairs.rod, stored, strict=True)}

    friction.view.stored[:, 0] = np.arange(contacts.match.size)
    known, x = slips(), model.x.copy()
    x[model.layout.of(1), 0] += 0.6
    contacts.search(x)
    friction.update(x)
    assert np.mean([known.get(pair) == slip for pair, slip in slips().items()]) > 0.95


def matched(old, old_u, new, new_u, reach) -> list[int]:
    match = np.empty(len(new), dtype=np.int64)
    match_pairs(old, old_u, new, new_u, np.array(reach), match)
    return match.tolist()


def test_matching_takes_the_nearest_within_reach_and_none_twice():
    old, old_u = np.array([[0, 0], [0, 0], [2, 1]]), np.array([3.0, 9.0, 5.0])
    new, new_u = np.array([[0, 0], [0, 0], [1, 0], [2, 0], [2, 1]]), np.array([3.4, 8.7, 3.0, 5.0, 7.0])
    assert matched(old, old_u, new, new_u, [1.5, 1.5]) == [0, 1, -1, -1, -1]
    assert matched(old, old_u, new[:1], new_u[:1], [0.3, 0.3]) == [-1]
    both = np.array([[0, 0], [0, 0]])
    assert matched(old[:1], old_u[:1], both, np.array([3.2, 3.1]), [1.5]) == [0, -1]
