"""Rigid surfaces, a sphere of the user's own among them: all that contact asks is the distance and its derivatives."""

from dataclasses import dataclass

import numpy as np
import pytest
from derivatives import assert_energy_gradient, assert_symmetric_storage, directional_error, residual, rotation
from reduced import begin, tangent_error
from specimens import make_rod, surfaces

import knotfem as kf
from knotfem.contact.curve import make_samples
from knotfem.contact.curve_obstacle_friction import CurveObstacleFriction
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.rigid import Foot, make_cylinder
from knotfem.errors import InputError
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.base import Additions
from knotfem.models.build import build_model
from knotfem.models.rod.frames import Frames

MU, RADIUS = 0.39, 10.0


@dataclass(frozen=True)
class Sphere:
    """What a user would write: nothing is inherited, nothing is compiled."""

    centre: np.ndarray
    radius: float

    def distance(self, points: np.ndarray) -> np.ndarray:
        return np.linalg.norm(points - self.centre, axis=1) - self.radius

    def foot(self, points: np.ndarray) -> Foot:
        arm = points - self.centre
        rho = np.linalg.norm(arm, axis=1)
        normal = arm / rho[:, None]
        across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        return Foot(rho - self.radius, normal, across / rho[:, None, None])


class Cavity(Sphere):
    """The inside of a sphere: rods are kept within."""

    def distance(self, points: np.ndarray) -> np.ndarray:
        return -super().distance(points)

    def foot(self, points: np.ndarray) -> Foot:
        foot = super().foot(points)
        return Foot(-foot.distance, -foot.normal, -foot.turn)


CENTRE = np.array([12.93, 0.4, 12.0])
SURFACES = {
    "cylinder": make_cylinder(CENTRE, np.array([0.0, 2.0, 1.0]), RADIUS),
    "sphere": Sphere(CENTRE, RADIUS),
    "cavity": Cavity(CENTRE, 40.0),
}


@pytest.mark.parametrize("name", list(SURFACES))
def test_normal_and_turn_are_derivatives_of_the_distance(name):
    rigid, step = SURFACES[name], 1e-5
    points = CENTRE + 12.0 * np.random.default_rng(0).standard_normal((30, 3))
    foot = rigid.foot(points)
    np.testing.assert_allclose(rigid.distance(points), foot.distance, rtol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(foot.normal, axis=1), 1.0, rtol=1e-13)
    for c in range(3):
        move = step * np.eye(3)[c]
        sides = [rigid.foot(points + sign * move) for sign in (1.0, -1.0)]
        slope = (sides[0].distance - sides[1].distance) / (2.0 * step)
        np.testing.assert_allclose(slope, foot.normal[:, c], atol=1e-8)
        np.testing.assert_allclose((sides[0].normal - sides[1].normal) / (2.0 * step), foot.turn[:, :, c], atol=1e-8)
    closest = points - foot.distance[:, None] * foot.normal
    np.testing.assert_allclose(rigid.distance(closest), 0.0, atol=1e-12)


@pytest.fixture
def ball(make_rest):
    """A hexahedral rod pressed a little into a sphere."""
    return make_rest(on=SURFACES["sphere"])


def test_tangent_is_the_derivative_of_the_residual(ball):
    assert directional_error([ball.contact], ball.x) < 1e-6
    assert ball.contact.touching > 10


@pytest.mark.parametrize("distance", [0.0, 0.08, 0.3])
def test_friction_tangent_is_the_derivative_of_the_residual(ball, distance):
    ball.slip(distance)
    assert directional_error([ball.contact, ball.friction], ball.x) < 1e-5


def test_tangent_of_normal_contact_is_symmetric(ball):
    assert_symmetric_storage([ball.contact], ball.x, tolerance=1e-12)


def test_energy_gradient_is_the_residual(ball):
    assert_energy_gradient(ball.contact, ball.x)


def test_frame_indifference(ball, make_rest):
    Q, shift = rotation(), 4.0
    turned = make_rest(Q, shift, Sphere(Q @ CENTRE + shift, RADIUS))
    f = residual([ball.contact], ball.x)
    np.testing.assert_allclose(residual([turned.contact], turned.x), f @ Q.T, atol=1e-11 * np.abs(f).max())


def test_normal_forces_have_no_moment_about_the_centre_and_friction_has(ball):
    ball.slip(0.0)
    arm = ball.x - CENTRE
    f = residual([ball.contact], ball.x)
    assert f[:, 0].sum() > 1.0
    assert np.abs(np.cross(arm, f).sum(axis=0)).max() < 1e-9
    ball.friction.view.anchor[:] += [0.0, 0.0, 2.0]
    f = residual([ball.contact, ball.friction], ball.x)
    assert np.abs(np.cross(arm, f).sum(axis=0)).max() > 1.0


def test_a_sphere_that_says_nothing_of_itself_is_called_by_its_class(ball):
    assert ball.contact.describe() == "Sphere"


def test_a_rod_pressed_into_a_sphere_bears_the_pressure_over_its_surface():
    """The gap at every point of the straight rod's surface is known; pressure times area by quadrature."""
    rod = make_rod(16.0, 16, section=104, match_bending=False)
    x = rod.mesh.nodes - [0.0, 0.0, 8.0]
    sphere = Sphere(np.array([RADIUS + 2.7, 0.0, 0.0]), RADIUS)
    f = residual([ObstacleContact(*surfaces([rod], 0.2), Penalty(11.4, 0.2), sphere)], x)
    angle, z = np.linspace(-np.pi, np.pi, 4001), np.linspace(-4.0, 4.0, 801)
    surface = np.stack(np.broadcast_arrays(3.0 * np.cos(angle), 3.0 * np.sin(angle), z[:, None]), axis=-1)
    arm = surface - sphere.centre
    distance = np.linalg.norm(arm, axis=-1)
    overlap = 0.1 - (distance - RADIUS)
    pressure = np.where(overlap < 0.0, 0.0, np.where(overlap < 0.2, overlap**2 / 0.4, overlap - 0.1))
    along_x = np.trapezoid(np.trapezoid(pressure * arm[..., 0] / distance, angle, axis=1), z)
    assert f[:, 0].sum() == pytest.approx(-11.4 * 3.0 * along_x, rel=0.01)
    np.testing.assert_allclose(f[:, 1:].sum(axis=0), 0.0, atol=1e-3 * f[:, 0].sum())


def test_sliding_traction_is_mu_times_pressure(ball):
    ball.slip(0.0)
    ball.friction.view.anchor[:] += [0.0, 0.0, 2.0]
    residual([ball.contact, ball.friction], ball.x)
    touching = ball.contact.touch.force > 0.0
    traction = ball.friction.view.traction[touching]
    size = np.linalg.norm(traction, axis=1)
    np.testing.assert_allclose(size, MU * ball.contact.touch.force[touching], rtol=1e-12)
    assert (traction[:, 2] > 0.9 * size).all()
    assert ball.friction.sliding == np.count_nonzero(touching)
    normal = ball.contact.obstacle.foot(ball.contact.points[touching]).normal
    np.testing.assert_allclose(np.einsum("si,si->s", traction, normal), 0.0, atol=1e-12)


def test_anchors_are_dragged_along_on_the_sphere(ball):
    """A rod pulled over the sphere step by step: in the end all samples slide, anchors a stick distance behind."""
    contact, friction = ball.contact, ball.friction
    x = ball.x.copy()
    residual([contact, friction], x)
    friction.commit(x)
    forces = []
    for _ in range(8):
        x = x + np.array([0.0, 0.0, 0.04])
        forces.append(residual([contact, friction], x)[:, 2].sum())
        friction.commit(x)
    slipped = np.linalg.norm(friction.view.anchor - CENTRE, axis=1)
    np.testing.assert_allclose(slipped, RADIUS, rtol=1e-12)
    f = residual([contact, friction], x)
    pressed = contact.touch.force > 0.01 * contact.touch.force.max()
    np.testing.assert_allclose(friction.view.slip[pressed], 0.1, rtol=0.05)
    assert friction.slides[pressed].mean() > 0.9
    assert f[:, 2].sum() == pytest.approx(MU * contact.touch.force.sum(), rel=0.05)
    assert (np.diff(forces[:3]) > 0.0).all()
    assert forces[-1] == pytest.approx(forces[-2], rel=0.03)


class Rope:
    """A discrete rod along z that is pressed into a sphere beside it."""

    def __init__(self, overlap: float, *, ramp: float = 0.2, noise: float = 0.0, samples: float = 0.75) -> None:
        rng = np.random.default_rng(3)
        self.layout = make_layout([12], [2.0], [3.0])
        x = np.zeros((self.layout.nodes, 4))
        x[:, 2] = 2.0 * np.arange(13) - 12.0
        x[:, :3] += noise * rng.standard_normal((13, 3))
        self.sphere = Sphere(np.array([RADIUS + 3.0 - overlap, 0.0, 0.0]), RADIUS)
        self.frames = Frames(self.layout, x, np.tile([1.0, 0.2, 0.1], (13, 1)))
        surface = CurveSurface(self.layout)
        self.contact = ObstacleContact(surface, make_samples(self.layout, samples), Penalty(0.95, ramp), self.sphere)
        law = CurveObstacleFriction(self.frames, 0.15)
        self.friction = Friction(self.contact, law, np.array([MU]), scheduled=False)
        self.terms = [self.frames, self.contact, self.friction]
        self.x = x
        begin(self.terms, x)

    def disturbed(self) -> np.ndarray:
        """Positions and angles near those at which the step began, with some slip."""
        rng = np.random.default_rng(5)
        self.friction.view.stored[:] = 0.1 * rng.standard_normal(self.friction.view.stored.shape)
        x = self.x + 0.03 * rng.standard_normal(self.x.shape)
        residual(self.terms, x)
        return x


def test_discrete_rods_on_a_sphere_have_their_tangents():
    rope = Rope(0.3, noise=0.02)
    x = rope.disturbed()
    assert 2 < rope.friction.sliding < rope.contact.touching - 2
    assert tangent_error([rope.frames, rope.contact], x) < 1e-6
    assert tangent_error(rope.terms, x) < 1e-6


def test_a_discrete_rod_pressed_into_a_sphere_has_the_closed_form():
    """Line force k (R + r - rho), rho^2 = s^2 + D^2, over -s0 to s0 where rho = R + r; D is the distance of the axis.

    Its part across the axis is k D (2 (R + r) asinh(s0/D) - 2 s0).
    """
    rope = Rope(0.3, ramp=1e-6, samples=0.02)
    reach, distance = RADIUS + 3.0, rope.sphere.centre[0]
    half = np.sqrt(reach**2 - distance**2)
    expected = 0.95 * distance * (2.0 * reach * np.arcsinh(half / distance) - 2.0 * half)
    f = residual([rope.contact], rope.x)
    assert f[:, 0].sum() == pytest.approx(expected, rel=1e-3)
    np.testing.assert_allclose(f[:, 1:].sum(axis=0), 0.0, atol=1e-9 * expected)
    assert rope.contact.penetration == pytest.approx(0.3, rel=1e-3)


@pytest.mark.parametrize("spin", [False, True])
def test_a_discrete_rod_that_slides_or_spins_on_a_sphere_rubs_with_mu_n(spin):
    """Along the rod by force, about its axis by the moment of the force on its radius."""
    rope = Rope(0.3)
    x, f = rope.x, np.zeros_like(rope.x)
    move = np.array([0.0, 0.0, 0.0, 0.3]) if spin else np.array([0.0, 0.0, 0.3, 0.0])
    for _ in range(3):
        x = x + move
        f = residual(rope.terms, x)
        for term in rope.terms:
            term.commit(x)
    normal = rope.contact.touch.force.sum()
    assert rope.friction.sliding == rope.contact.touching > 3
    column, arm = (3, 1.0 - 0.15 / 3.0) if spin else (2, 1.0)
    assert f[:, column].sum() == pytest.approx(MU * normal * arm, rel=0.06)


def test_history_of_a_discrete_rod_on_a_sphere_goes_to_other_terms_to_the_bit():
    rope, other = Rope(0.3, noise=0.02), Rope(0.3, noise=0.02)
    x = rope.disturbed()
    for term in rope.terms:
        term.commit(x)
    moved = x + 0.02
    for before, after in zip(rope.terms, other.terms, strict=True):
        after.load(before.history())
    assert residual(other.terms, moved).tobytes() == residual(rope.terms, moved).tobytes()
    assert np.abs(other.friction.view.stored).max() > 0.0


def test_rods_are_kept_within_a_cavity():
    rod = make_rod(12.0, 8)
    x = rod.mesh.nodes - [0.0, 0.0, 6.0]
    contact = ObstacleContact(*surfaces([rod], 0.75), Penalty(11.4, 0.2), Cavity(np.zeros(3), 6.65))
    f = residual([contact], x)
    assert contact.penetration > 0.05
    assert f[x[:, 2] > 5.0, 2].sum() > 0.1
    assert f[x[:, 2] < -5.0, 2].sum() < -0.1
    assert directional_error([contact], x) < 1e-6


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_both_models_take_a_sphere_into_a_scene(model):
    scene = kf.load_scene("capstan", [f"model={model}"])
    sphere = Sphere(np.array([0.0, 0.0, 500.0]), 10.0)
    built = build_model(scene, Additions(obstacles=(kf.Obstacle(sphere, friction=0.2),)))
    contacts = [term for term in built.terms if isinstance(term, ObstacleContact)]
    assert contacts[-1].obstacle is sphere
    assert [contact.name for contact in contacts] == ["cylinder", "obstacle"]
    (friction,) = (term for term in built.terms if isinstance(term, Friction) and term.contact is contacts[-1])
    assert friction.name == "obstacle friction"
    assert friction.number == contacts[-1].number == len(contacts) == 2
    np.testing.assert_array_equal(friction.mu, 0.2)


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_an_obstacle_in_a_scene_without_contact_is_refused(model):
    scene = kf.load_scene("cantilever", [f"model={model}"])
    assert not scene.contact.enabled
    with pytest.raises(InputError, match="obstacles need contact"):
        build_model(scene, Additions(obstacles=(kf.Obstacle(SURFACES["sphere"]),)))
