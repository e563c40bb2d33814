import numpy as np
import pytest
from derivatives import assert_energy_gradient, assert_symmetric_storage, directional_error, moments, residual, rotation
from specimens import make_rod, surfaces

from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact
from knotfem.solver.state import Motion
from knotfem.solver.term import TimeStep


def test_some_pairs_touch_on_ramp_and_beyond(crossing):
    crossing.contact.update(crossing.x)
    gap, ramp = crossing.contact.pairs.gap, crossing.contact.law.ramp
    assert np.count_nonzero(gap < -0.5 * ramp) > 5
    assert np.count_nonzero((gap > -0.5 * ramp) & (gap < 0.5 * ramp)) > 10
    assert crossing.contact.penetration == pytest.approx(-gap.min())


def test_penetration_is_not_that_of_a_surface_thought_on_beyond_an_end(crossing):
    contact = crossing.contact
    contact.update(crossing.x)
    pairs = contact.pairs
    deepest = int(pairs.gap.argmin())
    assert pairs.weight[deepest] == 0.5
    last = np.diff(contact.surface.stations.first)[pairs.rod[deepest]] - 1.0
    for beyond in (-0.2, last + 0.2):
        pairs.at[deepest, 0] = beyond
        assert contact.penetration == pytest.approx(-np.delete(pairs.gap, deepest).min())


def test_weight_of_a_pair_fades_beyond_the_end_of_a_rod(crossing):
    """Half on a rod, since each strand is secondary and primary in turn, and nothing from one slice beyond it."""
    contact = crossing.contact
    contact.update(crossing.x)
    last = np.diff(contact.surface.stations.first)[contact.pairs.rod[0]] - 1.0
    for u, weight in ((0.0, 0.5), (last, 0.5), (-0.3, 0.35), (last + 0.9, 0.05), (-1.0, 0.0), (-2.0, 0.0)):
        contact.pairs.at[0, 0] = u
        found = contact.surface.weights(crossing.x, contact.samples, contact.points, contact.pairs)
        assert found[0] == pytest.approx(weight)


def test_weights_follow_the_closest_point_from_step_to_step(crossing):
    """On tubes they are taken anew for each step, so that a rod may slide off another's end."""
    contact = crossing.contact
    contact.update(crossing.x)
    contact.pairs.weight[:] = 0.1
    contact.update(crossing.x)
    assert (contact.pairs.weight == 0.1).all()
    contact.begin(TimeStep(Motion.at_rest(crossing.x), 0.1))
    inside = (contact.pairs.at[:, 0] > 0.0) & (contact.pairs.at[:, 0] < 15.0)
    assert inside.any()
    assert (contact.pairs.weight[inside] == 0.5).all()


@pytest.mark.parametrize("graded", [False, True])
def test_tangent_is_the_derivative_of_the_residual(make_crossing, graded):
    crossing = make_crossing(graded=graded)
    assert directional_error([crossing.contact], crossing.x) < 1e-6


def test_upper_storage_equals_the_whole(crossing):
    assert_symmetric_storage([crossing.contact], crossing.x, tolerance=1e-10)


def test_energy_gradient_is_the_residual(crossing):
    assert_energy_gradient(crossing.contact, crossing.x)


def test_action_equals_reaction(crossing):
    f = residual([crossing.contact], crossing.x)
    first = len(crossing.rods[0].mesh.nodes)
    assert f[:first, 0].sum() > 1.0
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12 * np.abs(f).sum())
    np.testing.assert_allclose(moments(crossing.x, f), 0.0, atol=1e-11 * np.abs(f).sum())


def test_frame_indifference(crossing):
    Q = rotation()
    f = residual([crossing.contact], crossing.x)
    turned = residual([crossing.contact], crossing.x @ Q.T + [5.0, -8.0, 2.0])
    np.testing.assert_allclose(turned, f @ Q.T, atol=1e-10 * np.abs(f).max())


def test_order_of_the_rods_is_irrelevant(crossing, make_crossing):
    other = make_crossing((1, 0))
    f, g = residual([crossing.contact], crossing.x), residual([other.contact], other.x)
    first = len(crossing.rods[0].mesh.nodes)
    second = len(other.rods[0].mesh.nodes)
    np.testing.assert_allclose(g[second:], f[:first], atol=1e-11 * np.abs(f).max())
    np.testing.assert_allclose(g[:second], f[first:], atol=1e-11 * np.abs(f).max())
    assert other.contact.energy(other.x) == pytest.approx(crossing.contact.energy(crossing.x), rel=1e-12)


def test_reported_forces_add_up(crossing):
    crossing.contact.update(crossing.x)
    f = residual([crossing.contact], crossing.x)
    pairs = crossing.contact.pairs
    assert pairs.force.sum() > np.abs(f[: len(crossing.rods[0].mesh.nodes)].sum(axis=0)).max()
    secondary = crossing.contact.samples.rod[pairs.sample]
    halves = [pairs.force[secondary == rod].sum() for rod in (0, 1)]
    assert crossing.contact.touching == np.count_nonzero(pairs.force)
    assert halves[0] == pytest.approx(halves[1], rel=0.05)


def test_rods_apart_exert_nothing(crossing):
    x = crossing.x.copy()
    x[len(crossing.rods[0].mesh.nodes) :, 0] += 0.5
    assert np.abs(residual([crossing.contact], x)).max() == 0.0
    assert crossing.contact.penetration == 0.0


def test_neighbours_on_a_strand_are_not_pairs():
    rod = make_rod(40.0, 20)
    contact = PairContact(*surfaces([rod], 0.75), Penalty(11.4, 0.2))
    contact.update(rod.mesh.nodes)
    assert contact.pairs.sample.size == 0


def test_a_strand_meets_itself():
    rod = make_rod(60.0, 40)
    bend = np.pi / 20.0
    angle = np.clip(rod.mesh.nodes[:, 2] - 20.0, 0.0, 20.0) * bend
    radius = 20.0 / np.pi
    before = np.minimum(rod.mesh.nodes[:, 2], 20.0)
    after = np.maximum(rod.mesh.nodes[:, 2] - 40.0, 0.0)
    x = np.stack(
        [
            radius - (radius - rod.mesh.nodes[:, 0]) * np.cos(angle),
            rod.mesh.nodes[:, 1],
            before + (radius - rod.mesh.nodes[:, 0]) * np.sin(angle) - after,
        ],
        axis=1,
    )
    half = rod.mesh.nodes[:, 2] > 30.0
    x[half, 0] -= np.clip((rod.mesh.nodes[half, 2] - 40.0) / 20.0, 0.0, 1.0) * (2.0 * radius - 5.95)
    contact = PairContact(*surfaces([rod], 0.75), Penalty(11.4, 0.2))
    f = residual([contact], x)
    sections = rod.mesh.nodes[:, 2]
    assert f[sections < 20.0, 0].sum() > 0.1
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12)
    assert directional_error([contact], x) < 1e-6


def test_search_finds_the_same_as_following_the_pairs(crossing):
    contact, x = crossing.contact, crossing.x
    contact.update(x)
    searches = contact.generation
    moved = x.copy()
    moved[len(crossing.rods[0].mesh.nodes) :, 2] += 0.3
    followed = residual([contact], moved)
    assert contact.generation == searches
    contact.search(moved)
    np.testing.assert_allclose(residual([contact], moved), followed, atol=1e-9)


def test_predictor_may_not_close_a_pair_by_more_than_half_a_millimetre(crossing):
    contact = crossing.contact
    x = crossing.x.copy()
    x[len(crossing.rods[0].mesh.nodes) :, 0] += 0.3
    contact.update(x)
    move = np.zeros_like(x)
    move[len(crossing.rods[0].mesh.nodes) :, 0] = -2.0
    fraction = contact.allowed_fraction(x, move)
    assert fraction < 0.5
    assert contact.allowed_fraction(x, 0.05 * move) == 1.0
    assert contact.allowed_fraction(x, -move) == 1.0


def test_history_goes_round_to_the_bit(crossing):
    contact, x = crossing.contact, crossing.x
    before = residual([contact], x)
    contact.commit(x)
    history = contact.history()
    away = x.copy()
    away[len(crossing.rods[0].mesh.nodes) :, 2] += 4.0
    contact.update(away)
    contact.commit(away)
    contact.load(history)
    assert residual([contact], x).tobytes() == before.tobytes()
    for name, value in contact.history().items():
        assert value.tobytes() == history[name].tobytes(), name


def test_without_history_contact_begins_anew(crossing):
    contact, x = crossing.contact, crossing.x
    before = residual([contact], x)
    away = x.copy()
    away[len(crossing.rods[0].mesh.nodes) :, 2] += 0.3
    contact.update(away)
    contact.load({})
    assert contact.pairs.sample.size == 0
    assert residual([contact], x).tobytes() == before.tobytes()
    assert contact.couplings(len(x)) is not None


def test_normals_point_from_the_surface_to_the_sample(crossing):
    contact, x = crossing.contact, crossing.x
    residual([contact], x)
    on = np.flatnonzero(contact.pairs.force > 0.0)
    normals = contact.normals(on)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)
    secondary = contact.samples.rod[contact.pairs.sample[on]]
    assert (normals[secondary == 1, 0] > 0.5).all()
    assert (normals[secondary == 0, 0] < -0.5).all()
