import numpy as np
import pytest
from derivatives import assert_energy_gradient, assert_symmetric_storage, directional_error, residual, rotation
from specimens import make_rod, surfaces

from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.rigid import make_cylinder

STICK = 0.1


def test_tangent_is_the_derivative_of_the_residual(rest):
    assert directional_error([rest.contact], rest.x) < 1e-6


@pytest.mark.parametrize("distance", [0.0, 0.08, 0.3])
def test_friction_tangent_is_the_derivative_of_the_residual(rest, distance):
    rest.slip(distance)
    assert directional_error([rest.contact, rest.friction], rest.x) < 1e-5


def test_upper_storage_equals_the_whole(rest):
    assert_symmetric_storage([rest.contact], rest.x, tolerance=1e-12)


def test_energy_gradient_is_the_residual(rest):
    assert_energy_gradient(rest.contact, rest.x)


def test_forces_point_away_from_the_axis(rest):
    f = residual([rest.contact], rest.x)
    cylinder = rest.cylinder
    assert rest.contact.penetration > 0.05
    assert f.sum(axis=0) @ np.array([1.0, 0.0, 0.0]) > 1.0
    assert abs(f.sum(axis=0) @ cylinder.axis) < 1e-12
    moment = np.cross(rest.x - cylinder.origin, f).sum(axis=0)
    assert abs(moment @ cylinder.axis) < 1e-10
    assert rest.contact.touch.force.sum() >= np.linalg.norm(f.sum(axis=0))


def test_frame_indifference(rest, make_rest):
    Q = rotation()
    turned = make_rest(Q, 4.0)
    f = residual([rest.contact], rest.x)
    np.testing.assert_allclose(residual([turned.contact], turned.x), f @ Q.T, atol=1e-11 * np.abs(f).max())
    rest.slip()
    turned.contact.update(turned.x)
    turned.friction.update(turned.x)
    turned.friction.view.anchor[:] = rest.friction.view.anchor @ Q.T + 4.0
    f = residual([rest.contact, rest.friction], rest.x)
    g = residual([turned.contact, turned.friction], turned.x)
    np.testing.assert_allclose(g, f @ Q.T, atol=1e-10 * np.abs(f).max())


def test_gap_is_the_distance_from_the_axis_less_the_radius(rest):
    contact, cylinder = rest.contact, rest.cylinder
    contact.update(rest.x)
    p = contact.points[contact.touch.sample] - cylinder.origin
    distance = np.linalg.norm(np.cross(p, cylinder.axis), axis=1) - cylinder.radius
    np.testing.assert_allclose(contact.touch.gap, distance, atol=1e-12)
    assert distance.max() < 2.0
    assert contact.couplings(len(rest.x)) is not None


def test_predictor_may_not_drive_a_sample_inside_by_more_than_it_may(rest):
    """By half a millimetre, a sixth of the radius: a rod lifted by 1 mm and let down by 4 mm."""
    contact = rest.contact
    away = np.array([-1.0, 0.0, 0.0])
    x = rest.x + away
    contact.update(x)
    fraction = contact.allowed_fraction(x, np.tile(-4.0 * away, (len(x), 1)))
    assert 0.1 < fraction < 0.13
    assert contact.allowed_fraction(x, np.tile(-0.5 * away, (len(x), 1))) == 1.0
    assert contact.allowed_fraction(x, np.tile(4.0 * away, (len(x), 1))) == 1.0


def test_pressed_evenly_the_force_is_pressure_times_area():
    """A rod parallel to the cylinder's axis: the gap at every angle is known."""
    rod = make_rod(12.0, 8, section=104, match_bending=False)
    cylinder = make_cylinder(np.array([12.8, 0.0, 0.0]), np.array([0.0, 0.0, 2.0]), 10.0)
    contact = ObstacleContact(*surfaces([rod], 0.2), Penalty(11.4, 0.2), cylinder)
    f = residual([contact], rod.mesh.nodes)
    angle = np.linspace(-np.pi, np.pi, 20001)
    surface = 3.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1) - [12.8, 0.0]
    distance = np.linalg.norm(surface, axis=1)
    overlap = 0.1 - (distance - 10.0)
    pressure = np.where(overlap < 0.0, 0.0, np.where(overlap < 0.2, overlap**2 / 0.4, overlap - 0.1))
    expected = -11.4 * 12.0 * 3.0 * np.trapezoid(pressure * surface[:, 0] / distance, angle)
    assert f[:, 0].sum() == pytest.approx(expected, rel=0.01)
    per_section = f[rod.sections, 0].sum(axis=1)
    np.testing.assert_allclose(per_section[3:-3], f[:, 0].sum() * 1.5 / 12.0, rtol=1e-9)


def test_sliding_traction_is_mu_times_pressure(rest):
    rest.slip(0.0)
    rest.friction.view.anchor[:] += 2.0 * rest.cylinder.axis
    residual([rest.contact, rest.friction], rest.x)
    touching = rest.contact.touch.force > 0.0
    traction = rest.friction.view.traction[touching]
    np.testing.assert_allclose(np.linalg.norm(traction, axis=1), 0.39 * rest.contact.touch.force[touching], rtol=1e-12)
    assert (traction @ rest.cylinder.axis > 0.0).all()
    assert rest.friction.sliding == np.count_nonzero(touching)


def test_sliding_anchors_follow_at_the_stick_distance_on_the_surface(rest):
    contact, cylinder, friction = rest.contact, rest.cylinder, rest.friction
    rest.slip(0.0)
    friction.view.anchor[:] += 0.5 * cylinder.axis
    residual([contact, friction], rest.x)
    sliding = friction.view.slip > STICK
    free = contact.touch.force == 0.0
    friction.commit(rest.x)
    p = friction.view.anchor - cylinder.origin
    np.testing.assert_allclose(np.linalg.norm(np.cross(p, cylinder.axis), axis=1)[sliding | free], 10.0, rtol=1e-12)
    residual([contact, friction], rest.x)
    np.testing.assert_allclose(friction.view.slip[sliding], STICK, rtol=1e-3)
    stuck = friction.view.anchor[sliding].copy()
    friction.commit(rest.x)
    np.testing.assert_allclose(friction.view.anchor[sliding], stuck, atol=1e-4)


def test_history_goes_round_to_the_bit(rest):
    contact, friction, x = rest.contact, rest.friction, rest.x
    rest.slip()
    before = residual([contact, friction], x)
    history = contact.history(), friction.history()
    residual([contact, friction], x + 0.5)
    friction.commit(x + 0.5)
    contact.load(history[0])
    friction.load(history[1])
    assert residual([contact, friction], x).tobytes() == before.tobytes()


def test_history_goes_to_another_term_to_the_bit(rest, make_rest):
    rest.slip()
    before = residual([rest.contact, rest.friction], rest.x)
    other = make_rest()
    other.contact.load(rest.contact.history())
    other.friction.load(rest.friction.history())
    assert residual([other.contact, other.friction], rest.x).tobytes() == before.tobytes()


def test_without_history_samples_cling_to_where_they_are(rest):
    rest.slip()
    assert np.abs(residual([rest.contact, rest.friction], rest.x)).max() > 1e-3
    rest.friction.load({})
    assert np.abs(residual([rest.contact, rest.friction], rest.x)).max() < 1e-12


def test_friction_is_named_after_the_obstacle_it_belongs_to(rest):
    assert (rest.contact.name, rest.friction.name) == ("cylinder", "cylinder friction")
    assert rest.contact.external
    assert rest.friction.external
    assert rest.contact.describe() == "diameter 20 mm"
