import numpy as np
from reduced import RADIUS, contact, line, spec

from knotfem.contact.curve_search import match_pairs
from knotfem.models.rod.model import RodModel


def looped(turns: float, pitch: float) -> np.ndarray:
    phi = np.linspace(0.0, 2.0 * np.pi * turns, int(40 * turns) + 1)
    return np.stack([15.0 * np.cos(phi), 15.0 * np.sin(phi), pitch * phi / (2.0 * np.pi)], axis=1)


def by_hand(model: RodModel) -> set[tuple[int, int]]:
    """Pairs of samples and nearest whole segments, by looking at a fine polygon of the curve."""
    c = model.contact
    assert c is not None
    fine = np.concatenate([model.x[:, :3]])
    found = set()
    for s, point in enumerate(c.points):
        distance = np.linalg.norm(fine - point, axis=1)
        own = c.samples.u[s]
        far = np.abs(np.arange(len(fine)) - own) > 8
        for j in np.flatnonzero(far[1:-1] & (distance[1:-1] <= distance[:-2]) & (distance[1:-1] < distance[2:])) + 1:
            if distance[j] < 2 * RADIUS + 0.3:
                found.add((s, int(j)))
    return found


def test_finds_the_neighbouring_turns_of_a_coil():
    model = RodModel([spec(looped(3.0, 2 * RADIUS))], contact())
    model.begin({})
    c = model.contact
    assert c is not None
    expected = by_hand(model)
    found = {(int(s), round(u)) for (s, _), u in zip(c.pairs, c.u, strict=True)}
    assert len(expected) > 300
    for s, j in expected:
        assert {(s, j - 1), (s, j), (s, j + 1)} & found


def test_no_pair_twice():
    model = RodModel([spec(looped(3.0, 2 * RADIUS))], contact())
    model.begin({})
    c = model.contact
    assert c is not None
    keys = {(int(s), round(u, 3)) for (s, _), u in zip(c.pairs, c.u, strict=True)}
    assert len(keys) == len(c.pairs)


def test_a_pair_keeps_its_memory_while_it_slides_on():
    above = np.array([0.0, 0.0, 2 * RADIUS - 0.1])
    model = RodModel([spec(line(20, 40.0)), spec(line(20, 40.0) + above)], contact(0.3))
    model.begin({})
    c, friction = model.contact, model.friction
    assert c is not None
    assert friction is not None
    friction.stored[:, 0] = np.arange(len(c.pairs))
    known = {(int(s), int(rod)): value for (s, rod), value in zip(c.pairs, friction.stored[:, 0], strict=True)}
    x = model.x.copy()
    x[model.layout.of(1), 0] += 0.6
    c.search(x)
    friction.update(x)
    kept = [
        known.get((int(s), int(rod))) == value for (s, rod), value in zip(c.pairs, friction.stored[:, 0], strict=True)
    ]
    assert np.mean(kept) > 0.95


def test_matching_takes_the_nearest_within_reach_and_none_twice():
    old, old_u = np.array([[0, 0], [0, 0], [2, 1]]), np.array([3.0, 9.0, 5.0])
    new, new_u = np.array([[0, 0], [0, 0], [1, 0], [2, 0], [2, 1]]), np.array([3.4, 8.7, 3.0, 5.0, 7.0])
    assert match_pairs(old, old_u, new, new_u, np.array([1.5, 1.5])).tolist() == [0, 1, -1, -1, -1]
    assert match_pairs(old, old_u, new[:1], new_u[:1], np.array([0.3, 0.3])).tolist() == [-1]
    both = np.array([[0, 0], [0, 0]])
    assert match_pairs(old[:1], old_u[:1], both, np.array([3.2, 3.1]), np.array([1.5])).tolist() == [0, -1]
