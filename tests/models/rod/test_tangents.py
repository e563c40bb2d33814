"""Tangents of all effects against central differences of their residuals, and residuals against energies."""

import numpy as np
import pytest
from reduced import begun, gradient_error, residual, rotation, tangent, tangent_error

from knotfem.contact.curve import make_samples
from knotfem.contact.curve_contact import Contact
from knotfem.contact.curve_cylinder import Cylinder, CylinderFriction
from knotfem.contact.curve_friction import Friction
from knotfem.contact.penalty import Penalty
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.bend import Bend, turning
from knotfem.models.rod.ends import FollowingForce
from knotfem.models.rod.frames import Clamp, Frames
from knotfem.models.rod.stretch import Stretch
from knotfem.models.rod.twist import Twist
from knotfem.solver.term import Motion, StepStart


class Crooked:
    """Two crooked rods, three of their ends clamped, away from where the step set out."""

    def __init__(self):
        rng = np.random.default_rng(1)
        self.layout = make_layout([8, 5], [1.0, 1.3], [3.0, 2.0])
        x = np.zeros((self.layout.nodes, 4))
        for rod in range(2):
            nodes = self.layout.of(rod)
            x[nodes, 0] = np.arange(nodes.stop - nodes.start) * self.layout.spacing[rod]
            x[nodes, 1] += 5.0 * rod
        x[:, :3] += 0.25 * rng.normal(size=(self.layout.nodes, 3))
        self.frames = Frames(self.layout, x, rng.normal(size=(self.layout.nodes, 3)))
        clamps = []
        for node in (0, 9, 14):
            t = np.array([1.0, 0.0, 0.0]) + 0.3 * rng.normal(size=3)
            t /= np.linalg.norm(t)
            d = np.cross(t, rng.normal(size=3))
            d /= np.linalg.norm(d)
            clamps.append(Clamp(node, lambda time, t=t, d=d: (t, d)))
        clamps[2] = Clamp(self.layout.nodes - 1, clamps[2].orientation)
        self.frames.set_clamps(clamps, x, 0.0)
        self.x = x + 0.2 * rng.normal(size=x.shape)
        self.x[:, 3] = rng.normal(size=self.layout.nodes)


@pytest.fixture
def crooked():
    return Crooked()


def elastic(crooked, name):
    stiffness = np.array([90.0, 70.0])
    if name == "stretch":
        effect = Stretch(crooked.layout, stiffness, stiffness)
        effect.force = effect.tension(crooked.x)
        return effect
    return (Bend if name == "bend" else Twist)(crooked.frames, stiffness)


@pytest.mark.parametrize("name", ["stretch", "bend", "twist"])
def test_elastic_effects(crooked, name):
    effect = elastic(crooked, name)
    assert gradient_error([effect], crooked.x) < 1e-7
    assert tangent_error([effect], crooked.x) < 1e-7
    K = tangent([effect], crooked.x)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("scale", [1e-7, 1e-3, 2e-3])
def test_bend_of_nearly_straight_rods(scale):
    """Where the turning angle's closed form is replaced by its series, and beyond."""
    layout = make_layout([4], [1.0], [3.0])
    x = np.zeros((5, 4))
    x[:, 0] = np.arange(5)
    effect = Bend(Frames(layout, x, np.tile([0.0, 1.0, 0.0], (5, 1))), np.array([90.0]))
    straight = tangent([effect], x)
    x[:, 1] = scale * np.array([0.0, 0.1, 0.5, 0.2, -0.4])
    assert np.abs(tangent([effect], x) - straight).max() < 3.0 * 90.0 * scale
    assert tangent_error([effect], x) < 1e-6


@pytest.mark.parametrize("phi", [1e-8, 9e-4, 1.1e-3, 0.02, 1.0, 2.5])
def test_turning_angle_and_its_slopes(phi):
    """phi^2/2 by c = cos(phi): slopes -phi/sin(phi) and (1 - phi cot(phi))/sin(phi)^2, by their series where small."""
    found, first, second = turning(np.array([1.0, 0.0, 0.0]), np.array([np.cos(phi), np.sin(phi), 0.0]))
    assert found == pytest.approx(phi, rel=1e-12)
    assert first == pytest.approx(-phi / np.sin(phi), rel=1e-12)
    small = 1.0 / 3.0 + 2.0 * phi**2 / 15.0
    assert second == pytest.approx(small if phi < 0.05 else (1.0 - phi / np.tan(phi)) / np.sin(phi) ** 2, rel=1e-6)


def test_following_force(crooked):
    force = FollowingForce(12, 13, lambda time: 0.7)
    force.begin(StepStart(Motion.at_rest(crooked.x), 1.0))
    assert tangent_error([force], crooked.x) < 1e-8
    t = crooked.x[13, :3] - crooked.x[12, :3]
    np.testing.assert_allclose(residual([force], crooked.x)[13, :3], -0.7 * t / np.linalg.norm(t))
    assert gradient_error_at(force, crooked.x) < 1e-9


def gradient_error_at(force: FollowingForce, x: np.ndarray) -> float:
    """Of its merit, whose gradient at the place of the last assembly is the residual."""
    f, d = residual([force], x), np.random.default_rng(2).normal(size=x.shape)
    slope = (force.merit(x + 1e-3 * d) - force.merit(x - 1e-3 * d)) / 2e-3
    return abs(slope - float(np.sum(f * d))) / float(np.abs(f).max())


class Coiled:
    """A rod that crosses itself on a cylinder, a second one along it: all contacts at once."""

    def __init__(self):
        rng = np.random.default_rng(3)
        segments, R = 36, 14.0
        self.layout = make_layout([segments, 12], [2.0, 2.0], [3.0, 2.5])
        x = np.zeros((self.layout.nodes, 4))
        s = np.arange(segments + 1) * 2.0 - segments
        first, second = self.layout.of(0), self.layout.of(1)
        x[first, :3] = np.stack([R * np.sin(1.3 * s / R), -R * np.cos(1.3 * s / R), 0.075 * s], axis=1)
        phi = np.arange(13) * 2.0 / (R + 5.2)
        x[second, 0], x[second, 1], x[second, 2] = (R + 5.2) * np.sin(phi), -(R + 5.2) * np.cos(phi), 0.4
        x[:, :3] += 0.05 * rng.normal(size=(self.layout.nodes, 3))
        self.frames = Frames(self.layout, x, rng.normal(size=(self.layout.nodes, 3)))
        samples = make_samples(self.layout, 0.75)
        self.contact = Contact(self.layout, samples, Penalty(0.475, 0.1, 0.0))
        self.friction = Friction(self.contact, self.frames, np.array([[0.3, 0.4], [0.4, 0.5]]), 0.3)
        axis = np.array([0.0, 0.1, 1.0])
        self.cylinder = Cylinder(
            self.layout,
            samples,
            Penalty(0.95, 0.1, 0.0),
            np.array([0.1, 0.2, 0.0]),
            axis / np.linalg.norm(axis),
            R - 3.1,
        )
        self.rubbing = CylinderFriction(self.cylinder, self.frames, np.array([0.39, 0.2]), 0.6)
        self.effects = [self.frames, self.contact, self.friction, self.cylinder, self.rubbing]
        begun(self.effects, x)
        self.friction.stored = 0.05 * rng.normal(size=self.friction.stored.shape)
        self.rubbing.stored[:] = 0.05 * rng.normal(size=self.rubbing.stored.shape)
        self.x = x.copy()
        self.x[:, :3] += 0.03 * rng.normal(size=(self.layout.nodes, 3))
        self.x[:, 3] = 0.05 * rng.normal(size=self.layout.nodes)

    def upto(self, name):
        """All effects, the named one last."""
        chosen = {"contact": 1, "friction": 2, "cylinder": 3, "cylinder friction": 4}[name]
        return [e for i, e in enumerate(self.effects) if i != chosen] + [self.effects[chosen]]


@pytest.fixture(scope="module")
def coiled():
    return Coiled()


def test_the_specimen_sticks_and_slides(coiled):
    for effect in coiled.effects:
        residual(coiled.effects[: coiled.effects.index(effect) + 1], coiled.x)
    assert 5 < coiled.friction.sliding < np.count_nonzero(coiled.contact.force) - 5
    assert 5 < coiled.rubbing.sliding < np.count_nonzero(coiled.cylinder.force) - 5


@pytest.mark.parametrize("name", ["contact", "cylinder"])
def test_normal_forces_are_gradients(coiled, name):
    assert gradient_error(coiled.upto(name), coiled.x) < 1e-6


@pytest.mark.parametrize("name", ["contact", "friction", "cylinder", "cylinder friction"])
def test_contact_tangents(coiled, name):
    assert tangent_error(coiled.upto(name), coiled.x) < 1e-6


@pytest.mark.parametrize("name", ["contact", "friction"])
def test_forces_between_rods_balance(coiled, name):
    f = residual(coiled.upto(name), coiled.x)[:, :3]
    assert np.abs(f).max() > 0.01
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["contact", "friction"])
def test_turned_rods_feel_the_turned_forces(coiled, name):
    turned, Q = Coiled(), rotation()
    turned.friction.stored[:] = coiled.friction.stored
    turned.frames.tangent0, turned.frames.director0 = coiled.frames.tangent0 @ Q.T, coiled.frames.director0 @ Q.T
    x = coiled.x.copy()
    x[:, :3] = x[:, :3] @ Q.T
    count = 2 if name == "contact" else 3
    f, g = residual(coiled.effects[:count], coiled.x), residual(turned.effects[:count], x)
    np.testing.assert_allclose(g[:, :3], f[:, :3] @ Q.T, atol=1e-9)
    np.testing.assert_allclose(g[:, 3], f[:, 3], atol=1e-9)
