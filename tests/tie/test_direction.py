import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knotfem.geometry.vectors import angles_between
from knotfem.tie.direction import best_direction, candidate_directions


def sphere(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def largest_angle(tangents: np.ndarray, direction: np.ndarray) -> float:
    """Largest angle between the direction and the tangents, rad."""
    return float(angles_between(tangents, direction).max())


@given(seed=st.integers(0, 10**6), count=st.integers(4, 40), pole=st.floats(-2.0, 2.0))
@settings(max_examples=40, deadline=None)
def test_no_sampled_direction_is_better(seed, count, pole):
    rng = np.random.default_rng(seed)
    tangents = rng.normal(size=(count, 3)) + np.array([0.0, 0.0, pole])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    best = best_direction(tangents)
    assert np.linalg.norm(best) == pytest.approx(1.0, abs=1e-12)
    reached = largest_angle(tangents, best)
    assert all(reached <= largest_angle(tangents, other) + 1e-9 for other in sphere(rng, 400))
    nearby = best + 0.01 * sphere(rng, 100)
    assert all(reached <= largest_angle(tangents, other / np.linalg.norm(other)) + 1e-9 for other in nearby)


def test_one_tangent_is_its_own_best_direction():
    np.testing.assert_allclose(best_direction(np.tile([0.6, 0.0, 0.8], (9, 1))), (0.6, 0.0, 0.8), atol=1e-12)


def test_planar_turns_are_seen_from_across_the_plane():
    angle = np.linspace(0.0, 5.5, 60)
    tangents = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    np.testing.assert_allclose(np.abs(best_direction(tangents)), (0.0, 0.0, 1.0), atol=1e-12)
    assert largest_angle(tangents, best_direction(tangents)) == pytest.approx(np.pi / 2.0)


def test_quarter_turn_is_seen_from_its_middle():
    angle = np.linspace(0.0, np.pi / 2.0, 20)
    tangents = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    np.testing.assert_allclose(best_direction(tangents), (np.sqrt(0.5), np.sqrt(0.5), 0.0), atol=1e-12)


def test_candidates_are_apart_and_best_first(bowline):
    tangents = np.diff(bowline, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    candidates = candidate_directions(tangents, 4, apart=0.35)
    angles = [largest_angle(tangents, candidate) for candidate in candidates]
    assert len(candidates) == 4
    assert angles == sorted(angles)
    assert (candidates @ candidates.T - 2.0 * np.eye(4)).max() < np.cos(0.35)
