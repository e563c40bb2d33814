"""Tangents of contact and friction of discrete rods against central differences, normal forces against energies."""

import numpy as np
import pytest
from derivatives import rotation
from reduced import begin, gradient_error, residual, tangent_error

from knotfem.contact.curve import make_samples
from knotfem.contact.curve_friction import CurveFriction
from knotfem.contact.curve_obstacle_friction import CurveObstacleFriction
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.rigid import make_cylinder
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.frames import Frames


class Coiled:
    """A rod that crosses itself on a cylinder, a second one along it: all contacts at once."""

    def __init__(self, graded: bool = False):
        rng = np.random.default_rng(3)
        segments, R = 36, 14.0
        lengths = 2.0 + 0.6 * np.sin(np.arange(segments)) if graded else 2.0
        self.layout = make_layout([segments, 12], [lengths, 2.0], [3.0, 2.5])
        x = np.zeros((self.layout.nodes, 4))
        s = self.layout.arclength[self.layout.of(0)] - segments
        first, second = self.layout.of(0), self.layout.of(1)
        x[first, :3] = np.stack([R * np.sin(1.3 * s / R), -R * np.cos(1.3 * s / R), 0.075 * s], axis=1)
        phi = np.arange(13) * 2.0 / (R + 5.2)
        x[second, 0], x[second, 1], x[second, 2] = (R + 5.2) * np.sin(phi), -(R + 5.2) * np.cos(phi), 0.4
        x[:, :3] += 0.05 * rng.normal(size=(self.layout.nodes, 3))
        self.frames = Frames(self.layout, x, rng.normal(size=(self.layout.nodes, 3)))
        surface, samples = CurveSurface(self.layout), make_samples(self.layout, 0.75)
        self.contact = PairContact(surface, samples, Penalty(0.475, 0.1))
        law = CurveFriction(self.frames, 0.08)
        self.friction = Friction(self.contact, law, np.array([[0.3, 0.4], [0.4, 0.5]]))
        cylinder = make_cylinder(np.array([0.1, 0.2, 0.0]), np.array([0.0, 0.1, 1.0]), R - 3.1)
        self.cylinder = ObstacleContact(surface, samples, Penalty(0.95, 0.1), cylinder)
        self.rubbing = Friction(self.cylinder, CurveObstacleFriction(self.frames, 0.08), np.array([0.39, 0.2]))
        self.terms = [self.frames, self.contact, self.friction, self.cylinder, self.rubbing]
        begin(self.terms, x)
        self.friction.view.stored[:] = 0.05 * rng.normal(size=self.friction.view.stored.shape)
        self.rubbing.view.stored[:] = 0.05 * rng.normal(size=self.rubbing.view.stored.shape)
        self.x = x.copy()
        self.x[:, :3] += 0.03 * rng.normal(size=(self.layout.nodes, 3))
        self.x[:, 3] = 0.05 * rng.normal(size=self.layout.nodes)

    def upto(self, name):
        """All terms, the named one last."""
        chosen = {"contact": 1, "friction": 2, "cylinder": 3, "cylinder friction": 4}[name]
        return [e for i, e in enumerate(self.terms) if i != chosen] + [self.terms[chosen]]


@pytest.fixture(scope="module", params=[False, True], ids=["equal", "graded"])
def coiled(request):
    return Coiled(request.param)


def test_the_specimen_sticks_and_slides(coiled):
    for count in range(len(coiled.terms)):
        residual(coiled.terms[: count + 1], coiled.x)
    assert 5 < coiled.friction.sliding < coiled.contact.touching - 5
    assert 5 < coiled.rubbing.sliding < coiled.cylinder.touching - 5


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
    turned, Q = Coiled(bool(np.ptp(coiled.layout.spacing[:36]) > 0.0)), rotation()
    turned.friction.view.stored[:] = coiled.friction.view.stored
    view = coiled.frames.view
    turned.frames.view = view._replace(tangent=view.tangent @ Q.T, director=view.director @ Q.T)
    x = coiled.x.copy()
    x[:, :3] = x[:, :3] @ Q.T
    count = 2 if name == "contact" else 3
    f, g = residual(coiled.terms[:count], coiled.x), residual(turned.terms[:count], x)
    np.testing.assert_allclose(g[:, :3], f[:, :3] @ Q.T, atol=1e-9)
    np.testing.assert_allclose(g[:, 3], f[:, 3], atol=1e-9)
