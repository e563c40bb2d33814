import numpy as np
import pytest
from derivatives import directional_error, gradient_error, residual, rotation, tangent
from specimens import make_rod

from knotfem.geometry.finite_rotation import rotate
from knotfem.solver.constraints import Prescribed, driven, held
from knotfem.solver.state import Motion
from knotfem.solver.term import TimeStep
from knotfem.terms.load import EndForce, FollowingForce


@pytest.fixture
def rod():
    return make_rod(8.0, 4)


@pytest.fixture
def x(rod):
    return rod.mesh.nodes + 0.1 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)


def begin(load, x, time=2.0):
    load.begin(TimeStep(Motion.at_rest(x), time))
    return load


def following(rod, x, weights=None) -> FollowingForce:
    weights = rod.end_weights if weights is None else weights
    load = FollowingForce(rod.sections[-1], weights, int(rod.axis[-2]), int(rod.axis[-1]), lambda time: 1.5 * time)
    return begin(load, x)


def test_dead_force_is_shared_and_derives_from_its_merit(rod, x):
    direction = np.array([0.6, 0.0, 0.8])
    load = begin(EndForce(rod.sections[-1], rod.end_weights, lambda time: 1.5 * time * direction), x)
    f = residual([load], x)
    np.testing.assert_allclose(f.sum(axis=0), -3.0 * direction)
    assert np.abs(f[rod.sections[:-1]]).max() == 0.0
    assert gradient_error(load.merit, f, x) < 1e-9
    assert np.abs(tangent([load], x)).max() == 0.0


def test_following_force_has_its_tangent(rod, x):
    load = following(rod, x)
    assert directional_error([load], x) < 1e-7
    assert not load.symmetric


def test_merit_of_a_following_force_falls_along_it(rod, x):
    load = following(rod, x)
    f = residual([load], x)
    assert gradient_error(load.merit, f, x) < 1e-9


def test_following_force_acts_along_the_end(rod, x):
    load = following(rod, x)
    t = x[rod.axis[-1]] - x[rod.axis[-2]]
    np.testing.assert_allclose(residual([load], x).sum(axis=0), -3.0 * t / np.linalg.norm(t))


def test_following_force_turns_with_the_rod(rod, x):
    load, Q = following(rod, x), rotation()
    f = residual([load], x)
    np.testing.assert_allclose(residual([load], x @ Q.T + 2.0), f @ Q.T, atol=1e-12)


def test_weights_like_a_section_coordinate_make_a_couple(rod):
    x = rod.mesh.nodes
    load = following(rod, x, rod.couple_weights(0))
    f = -residual([load], x)
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose(np.cross(x, f).sum(axis=0), [0.0, -3.0, 0.0], atol=1e-12)
    assert directional_error([load], x) < 1e-7


def test_a_following_force_on_a_discrete_rod_has_its_tangent():
    """One node carries it; the angle has no part in it."""
    x = np.zeros((4, 4))
    x[:, 2] = 2.0 * np.arange(4)
    x += 0.1 * np.random.default_rng(0).standard_normal(x.shape)
    load = begin(FollowingForce(np.array([3]), np.ones(1), 2, 3, lambda time: 1.5 * time), x)
    t = (x[3] - x[2])[:3]
    f = residual([load], x)
    np.testing.assert_allclose(f[3, :3], -3.0 * t / np.linalg.norm(t))
    assert not f[:3].any()
    assert not f[:, 3].any()
    assert directional_error([load], x) < 1e-7
    dead = begin(EndForce(np.array([0]), np.ones(1), lambda time: np.array([time, 0.0, 0.0])), x)
    np.testing.assert_allclose(residual([dead], x)[0], [-2.0, 0.0, 0.0, 0.0])


def test_a_force_is_that_of_the_end_of_the_step(rod, x):
    load = EndForce(rod.sections[-1], rod.end_weights, lambda time: np.array([time, 0.0, 0.0]))
    load.begin(TimeStep(Motion.at_rest(x, 2.0), 0.5))
    assert residual([load], x)[:, 0].sum() == pytest.approx(-2.5)
    load.begin(TimeStep(Motion.at_rest(x, 2.0), 0.0))
    assert residual([load], x)[:, 0].sum() == pytest.approx(-2.0)


def test_prescribed_motions(rod):
    nodes = rod.sections[-1]
    X = rod.mesh.nodes[nodes]
    np.testing.assert_array_equal(held(nodes, X).positions(5.0), X)
    direction = np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(driven(nodes, X, direction, lambda t: 2 * t).positions(3.0), X + 6.0 * direction)
    centre, axis = np.array([1.0, 0.0, 8.0]), np.array([0.0, 0.0, 1.0])
    turned = Prescribed(nodes, lambda time: centre + rotate(X - centre, axis, time))
    quarter = turned.positions(np.pi / 2)
    expected = np.stack([1.0 - X[:, 1], X[:, 0] - 1.0, X[:, 2]], axis=1)
    np.testing.assert_allclose(quarter, expected, atol=1e-14)
