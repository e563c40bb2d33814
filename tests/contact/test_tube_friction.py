import numpy as np
import pytest
from derivatives import directional_error, moments, residual, rotation, tangent

from knotfem.contact.friction import Friction
from knotfem.contact.tube_friction import TubeFriction
from knotfem.solver.state import Motion
from knotfem.solver.term import Conditions, TimeStep

STICK = 0.1


def step_of(x: np.ndarray, factor: float) -> TimeStep:
    """A step of 1 s at whose end the coefficients are multiplied by a factor."""
    return TimeStep(Motion.at_rest(x), 1.0, conditions=Conditions(friction=lambda time: factor * time))


@pytest.fixture
def slipped(crossing):
    crossing.slip()
    return crossing


def test_some_pairs_stick_and_some_slide(slipped):
    residual([slipped.contact, slipped.friction], slipped.x)
    touching = slipped.contact.pairs.force > 0.0
    slip = slipped.friction.view.slip[touching]
    assert np.count_nonzero(slip < 0.1) > 10
    slipped.slip(0.3)
    residual([slipped.contact, slipped.friction], slipped.x)
    assert slipped.friction.sliding > 10


@pytest.mark.parametrize("graded", [False, True])
@pytest.mark.parametrize("distance", [0.02, 0.3])
def test_tangent_is_the_derivative_of_the_residual(make_crossing, distance, graded):
    crossing = make_crossing(graded=graded)
    crossing.slip(distance)
    assert directional_error([crossing.contact, crossing.friction], crossing.x) < 1e-5


def test_keys_cover_anchors_far_behind(crossing):
    crossing.slip(0.0)
    crossing.friction.view.anchor[:, 0] += 4.0
    assert directional_error([crossing.contact, crossing.friction], crossing.x) < 1e-5


def test_forces_balance_and_moments_up_to_the_gap(slipped):
    f = residual([slipped.contact, slipped.friction], slipped.x)
    size = np.linalg.norm(slipped.friction.view.traction, axis=1).sum()
    assert size > 0.05
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12 * size)
    largest_gap = np.abs(slipped.contact.pairs.gap[slipped.contact.pairs.force > 0.0]).max()
    assert np.linalg.norm(moments(slipped.x, f)) < 1.05 * largest_gap * size


def test_frame_indifference(slipped):
    Q = rotation()
    f = residual([slipped.contact, slipped.friction], slipped.x)
    slipped.contact.search(slipped.x)
    slipped.friction.update(slipped.x)
    turned = slipped.x @ Q.T + [5.0, -8.0, 2.0]
    g = residual([slipped.contact, slipped.friction], turned)
    np.testing.assert_allclose(g, f @ Q.T, atol=1e-8 * np.abs(f).max())


def test_rigid_rolling_along_does_no_work(slipped):
    rate = np.array([0.3, -0.2, 0.5])
    f = residual([slipped.contact, slipped.friction], slipped.x)
    scale = np.abs(f).sum()
    assert abs(np.sum(f * rate)) < 1e-12 * scale


def test_order_of_the_rods_is_irrelevant(make_crossing):
    results = []
    for order in ((0, 1), (1, 0)):
        c = make_crossing(order)
        c.contact.update(c.x)
        c.friction.update(c.x)
        c.friction.view.anchor[:, 0] += 0.02
        c.friction.view.anchor[:, 1] -= 0.01
        f = residual([c.contact, c.friction], c.x)
        split = len(c.rods[0].mesh.nodes)
        results.append((f[:split], f[split:]) if order == (0, 1) else (f[split:], f[:split]))
    scale = np.abs(results[0][0]).max()
    for first, second in zip(*results, strict=True):
        np.testing.assert_allclose(first, second, atol=1e-9 * scale)


def test_sliding_traction_is_mu_times_pressure_against_the_slip(crossing):
    crossing.slip(0.0)
    crossing.friction.view.anchor[:, 0] -= 1.0
    residual([crossing.contact, crossing.friction], crossing.x)
    touching = crossing.contact.pairs.force > 0.0
    size = np.linalg.norm(crossing.friction.view.traction[touching], axis=1)
    np.testing.assert_allclose(size, 0.4 * crossing.contact.pairs.force[touching], rtol=1e-12)


def test_without_slip_there_is_no_traction(crossing):
    crossing.slip(0.0)
    assert np.abs(residual([crossing.contact, crossing.friction], crossing.x)).max() < 1e-12


def test_sliding_anchors_follow_at_the_stick_distance_and_free_ones_at_the_closest_point(crossing):
    crossing.slip(0.0)
    contact, friction = crossing.contact, crossing.friction
    friction.view.anchor[:, 0] -= 0.5
    residual([contact, friction], crossing.x)
    free = contact.pairs.force == 0.0
    sliding = friction.view.slip > STICK
    assert sliding.any()
    assert free.any()
    friction.commit(crossing.x)
    np.testing.assert_array_equal(friction.view.anchor[free], contact.pairs.at[free])
    residual([contact, friction], crossing.x)
    np.testing.assert_allclose(friction.view.slip[sliding], STICK, rtol=0.02)


def test_sticking_anchors_never_creep(slipped):
    contact, friction = slipped.contact, slipped.friction
    friction.view.anchor[:] = contact.pairs.at
    friction.view.anchor[:, 0] += 0.01
    residual([contact, friction], slipped.x)
    stuck = (contact.pairs.force > 0.0) & (friction.view.slip > 0.0)
    assert stuck.any()
    before = friction.view.anchor[stuck].copy()
    for _ in range(100):
        friction.commit(slipped.x)
    np.testing.assert_array_equal(friction.view.anchor[stuck], before)


def test_anchors_survive_a_new_search(slipped):
    contact, friction = slipped.contact, slipped.friction
    f = residual([contact, friction], slipped.x)
    contact.search(slipped.x)
    np.testing.assert_allclose(residual([contact, friction], slipped.x), f, atol=1e-9 * np.abs(f).max())


def test_factor_scales_the_coefficient(slipped):
    contact = slipped.contact
    friction = Friction(contact, TubeFriction(STICK), np.full((2, 2), 0.4))
    friction.update(slipped.x)
    friction.view.anchor[:] = slipped.friction.view.anchor
    friction.begin(step_of(slipped.x, 0.5))
    half = residual([contact, friction], slipped.x)
    whole = residual([contact, slipped.friction], slipped.x)
    np.testing.assert_allclose(half, 0.5 * whole, atol=1e-13)


def test_conditions_that_say_nothing_keep_the_factor_of_the_step_before(slipped):
    friction = slipped.friction
    friction.begin(step_of(slipped.x, 0.5))
    friction.begin(TimeStep(Motion.at_rest(slipped.x), 1.0))
    np.testing.assert_allclose(friction.mu, 0.2)


def test_friction_that_is_not_scheduled_keeps_its_coefficients(slipped):
    friction = Friction(slipped.contact, TubeFriction(STICK), np.full((2, 2), 0.4), scheduled=False)
    friction.begin(step_of(slipped.x, 0.5))
    np.testing.assert_allclose(friction.mu, 0.4)


def test_each_pair_of_rods_has_a_coefficient_of_its_own(slipped):
    friction = Friction(slipped.contact, TubeFriction(STICK), np.array([[0.1, 0.2], [0.3, 0.4]]))
    residual([slipped.contact, friction], slipped.x)
    own = slipped.contact.samples.rod[slipped.contact.pairs.sample]
    np.testing.assert_array_equal(friction.mu, np.where(own == 0, 0.2, 0.3))


def test_potential_gives_the_friction_at_fixed_normal_force(crossing):
    """In the limit of a gap that does not change, the merit's slope is the residual."""
    crossing.slip(0.02)
    contact, friction, x = crossing.contact, crossing.friction, crossing.x
    f = residual([contact, friction], x)
    d = np.zeros_like(x)
    d[len(crossing.rods[0].mesh.nodes) :, 1:] = [0.6, 0.8]
    slope = (friction.merit(x + 1e-6 * d) - friction.merit(x - 1e-6 * d)) / 2e-6
    assert slope == pytest.approx(float(np.sum(f * d)), rel=0.05)


def test_unsymmetric_systems_are_stored_whole(slipped):
    assert not slipped.friction.symmetric
    matrix = tangent([slipped.contact, slipped.friction], slipped.x)
    assert np.abs(matrix - matrix.T).max() > 1e-3 * np.abs(matrix).max()


def test_history_goes_round_to_the_bit(slipped):
    contact, friction, x = slipped.contact, slipped.friction, slipped.x
    before = residual([contact, friction], x)
    history = contact.history(), friction.history()
    away = x.copy()
    away[len(slipped.rods[0].mesh.nodes) :, 2] += 2.0
    residual([contact, friction], away)
    friction.commit(away)
    contact.load(history[0])
    friction.load(history[1])
    assert residual([contact, friction], x).tobytes() == before.tobytes()


def test_history_goes_to_another_term_to_the_bit(slipped, make_crossing):
    """As a run does that is resumed: anchors, and which pair each belongs to, come with it."""
    contact, friction, x = slipped.contact, slipped.friction, slipped.x
    friction.begin(step_of(x, 0.5))
    before = residual([contact, friction], x)
    other = make_crossing()
    other.contact.load(contact.history())
    other.friction.load(friction.history())
    assert residual([other.contact, other.friction], x).tobytes() == before.tobytes()
    moved = x.copy()
    moved[len(slipped.rods[0].mesh.nodes) :, 2] += 0.4
    searches = other.contact.generation
    first, second = residual([contact, friction], moved), residual([other.contact, other.friction], moved)
    assert other.contact.generation == searches + 1
    assert first.tobytes() == second.tobytes()


def test_history_is_a_copy(slipped):
    contact, friction, x = slipped.contact, slipped.friction, slipped.x
    residual([contact, friction], x)
    history = friction.history()
    kept = {name: value.tobytes() for name, value in history.items()}
    friction.load(history)
    friction.view.anchor[:] += 1.0
    friction.begin(step_of(x, 0.1))
    residual([contact, friction], x)
    friction.commit(x)
    assert {name: value.tobytes() for name, value in history.items()} == kept


def test_without_history_pairs_cling_to_where_they_are(slipped):
    contact, friction, x = slipped.contact, slipped.friction, slipped.x
    friction.begin(step_of(x, 0.5))
    assert np.abs(residual([contact, friction], x)).max() > 1e-3
    friction.load({})
    np.testing.assert_allclose(friction.mu, 0.4)
    assert np.abs(residual([contact, friction], x)).max() < 1e-12
    np.testing.assert_array_equal(friction.view.anchor, contact.pairs.at)


def test_history_without_anchors_is_that_of_friction_that_has_not_begun(slipped, make_crossing):
    fresh = make_crossing()
    history = fresh.friction.history()
    assert set(history) == {"factor"}
    slipped.friction.load(history)
    assert np.abs(residual([slipped.contact, slipped.friction], slipped.x)).max() < 1e-12


def test_anchors_of_pairs_that_do_not_rub_follow(slipped):
    """Friction that comes on late holds from where it comes on."""
    friction, contact = slipped.friction, slipped.contact
    friction.begin(step_of(slipped.x, 0.0))
    residual([contact, friction], slipped.x)
    assert (contact.pairs.force > 0.0).any()
    friction.commit(slipped.x)
    np.testing.assert_array_equal(friction.view.anchor, contact.pairs.at)


def test_history_knows_the_factor(slipped):
    friction = slipped.friction
    friction.begin(step_of(slipped.x, 0.25))
    kept, mu = friction.history(), friction.mu.copy()
    friction.begin(step_of(slipped.x, 0.5))
    friction.load(kept)
    np.testing.assert_array_equal(friction.mu, mu)


def test_work_of_anchored_friction_is_that_of_its_forces(slipped):
    """The law keeps no energy that would come back, and leaves the work to whoever knows the motion."""
    residual([slipped.contact, slipped.friction], slipped.x)
    slipped.friction.commit(slipped.x)
    assert slipped.friction.dissipation() is None
    assert slipped.friction.energy(slipped.x) == 0.0
