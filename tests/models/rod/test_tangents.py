"""Tangents of elasticity and loads against central differences of their residuals, and residuals against energies."""

import numpy as np
import pytest
from reduced import begin, gradient_error, residual, tangent, tangent_error

from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.bend import Bend, turning
from knotfem.models.rod.frames import Frames
from knotfem.models.rod.twist import Twist
from knotfem.solver.constraints import Clamp
from knotfem.terms.axial import AxialStiffness
from knotfem.terms.load import FollowingForce


class Crooked:
    """Two crooked rods, three of their ends clamped, away from where the step set out."""

    def __init__(self):
        rng = np.random.default_rng(1)
        self.layout = make_layout([8, 5], [1.0, 1.3], [3.0, 2.0])
        x = np.zeros((self.layout.nodes, 4))
        for rod in range(2):
            nodes = self.layout.of(rod)
            x[nodes, 0] = self.layout.arclength[nodes]
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
        self.frames.clamped_at(clamps, x, 0.0)
        self.x = x + 0.2 * rng.normal(size=x.shape)
        self.x[:, 3] = rng.normal(size=self.layout.nodes)


@pytest.fixture
def crooked():
    return Crooked()


def elastic(crooked, name):
    stiffness = np.array([90.0, 70.0])
    if name == "stretch":
        edges, rod = crooked.layout.edges, crooked.layout.rod[crooked.layout.edges]
        pairs = np.stack([edges, edges + 1], axis=1)
        term = AxialStiffness(name, pairs, crooked.layout.spacing[edges], stiffness[rod], stiffness[rod])
        term.view.force[:] = term.tension(crooked.x)
        return term
    return (Bend if name == "bend" else Twist)(crooked.frames, stiffness)


@pytest.mark.parametrize("name", ["stretch", "bend", "twist"])
def test_elastic_terms(crooked, name):
    term = elastic(crooked, name)
    assert gradient_error([term], crooked.x) < 1e-7
    assert tangent_error([term], crooked.x) < 1e-7
    K = tangent([term], crooked.x)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("scale", [1e-7, 1e-3, 2e-3])
def test_bend_of_nearly_straight_rods(scale):
    """Where the turning angle's closed form is replaced by its series, and beyond."""
    layout = make_layout([4], [1.0], [3.0])
    x = np.zeros((5, 4))
    x[:, 0] = np.arange(5)
    term = Bend(Frames(layout, x, np.tile([0.0, 1.0, 0.0], (5, 1))), np.array([90.0]))
    straight = tangent([term], x)
    x[:, 1] = scale * np.array([0.0, 0.1, 0.5, 0.2, -0.4])
    assert np.abs(tangent([term], x) - straight).max() < 3.0 * 90.0 * scale
    assert tangent_error([term], x) < 1e-6


@pytest.mark.parametrize("phi", [1e-8, 9e-4, 1.1e-3, 0.02, 1.0, 2.5])
def test_turning_angle_and_its_slopes(phi):
    """phi^2/2 by c = cos(phi): slopes -phi/sin(phi) and (1 - phi cot(phi))/sin(phi)^2, by their series where small."""
    found, first, second = turning(np.array([1.0, 0.0, 0.0]), np.array([np.cos(phi), np.sin(phi), 0.0]))
    assert found == pytest.approx(phi, rel=1e-12)
    assert first == pytest.approx(-phi / np.sin(phi), rel=1e-12)
    small = 1.0 / 3.0 + 2.0 * phi**2 / 15.0
    assert second == pytest.approx(small if phi < 0.05 else (1.0 - phi / np.tan(phi)) / np.sin(phi) ** 2, rel=1e-6)


def test_following_force(crooked):
    force = FollowingForce(np.array([13]), np.ones(1), 12, 13, lambda time: 0.7)
    begin([force], crooked.x)
    assert tangent_error([force], crooked.x) < 1e-8
    t = crooked.x[13, :3] - crooked.x[12, :3]
    np.testing.assert_allclose(residual([force], crooked.x)[13, :3], -0.7 * t / np.linalg.norm(t))
    assert gradient_error_at(force, crooked.x) < 1e-9


def gradient_error_at(force: FollowingForce, x: np.ndarray) -> float:
    """Of its merit, whose gradient at the place of the last assembly is the residual."""
    f, d = residual([force], x), np.random.default_rng(2).normal(size=x.shape)
    slope = (force.merit(x + 1e-3 * d) - force.merit(x - 1e-3 * d)) / 2e-3
    return abs(slope - float(np.sum(f * d))) / float(np.abs(f).max())
