"""Discrete rods on a rigid cylinder."""

import numpy as np
import pytest
from reduced import RADIUS, Rods, begun, contact, line, peg, spec

from knotfem.contact.friction import Friction
from knotfem.models.rod.spec import ContactSpec
from knotfem.solver.stepping.controller import StepController
from knotfem.theory import capstan_exponent

MU, CYLINDER = 0.33, 10.0
DOWN = np.array([0.0, 0.0, -1.0])


def rope(h: float, leg: float) -> tuple[np.ndarray, float]:
    """Half a turn over a cylinder along y with two legs down, and the radius of the centreline."""
    rho = CYLINDER + RADIUS
    phi = np.linspace(0.0, np.pi, round(np.pi * rho / h) + 1)
    arc = rho * np.stack([-np.cos(phi), 0.0 * phi, np.sin(phi)], axis=1)
    chord = np.linalg.norm(arc[1] - arc[0])
    below = chord * np.arange(1, int(leg / chord) + 1)[:, None] * DOWN
    return np.concatenate([below[::-1] + arc[0], arc, below + arc[-1]]), rho


@pytest.mark.parametrize("h", [2.0, 1.0])
def test_capstan_of_a_thick_rope(h):
    """ln T grows with the angle by Lambda, mu a Lambda^2 + Lambda = mu (1 - a), a = r/(R + r); a thin rope's by mu."""
    load, pull = 2.0, 1.0
    points, rho = rope(h, 20.0)
    over = peg([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], CYLINDER, MU)
    touch = ContactSpec(10.0, MU, ramp=0.1, stick=0.03, sample_spacing=0.5)
    model = Rods([spec(points, bending=1.0, twisting=0.7, mass_per_length=1e-9)], touch, [over], drag=20.0)
    place = points[0].copy()
    pulled = model.placed("start", lambda t: place + max(t - 0.2, 0.0) * 2.0 * pull * DOWN)
    model.begin(pulled, model.loaded("end", lambda t: load * min(5.0 * t, 1.0) * DOWN))
    model.run(StepController(0.05, 1e-6, 0.05, RADIUS), 0.2, 0.7, newton=model.newton(2e-6))
    exponent = capstan_exponent(MU, RADIUS / rho)
    c = model.contacts()
    middles = (np.arange(len(points) - 1) + 0.5) * model.layout.spacing[0]
    inside = (middles > c.arclength.min() + 3.0) & (middles < c.arclength.max() - 3.0)
    edges = np.diff(model.centreline(), axis=0)
    angle = np.unwrap(np.arctan2(edges[:, 2], edges[:, 0]))
    slope = -np.polyfit(-angle[inside], np.log(model.tension()[inside]), 1)[0]
    assert np.all(c.slides)
    assert slope == pytest.approx(exponent, rel=0.01)
    assert np.linalg.norm(model.reaction("start")) / load == pytest.approx(np.exp(np.pi * exponent), rel=0.01)


def test_a_rod_without_friction_pulls_through():
    load = 2.0
    points, _ = rope(2.0, 20.0)
    over = peg([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], CYLINDER, 0.0)
    touch = ContactSpec(10.0, 0.0, ramp=0.1, stick=0.03, sample_spacing=0.5)
    model = Rods([spec(points, bending=1.0, mass_per_length=1e-9)], touch, [over], drag=20.0)
    assert not model.having(Friction)
    model.begin(model.pinned("start"), model.loaded("end", lambda t: load * min(5.0 * t, 1.0) * DOWN))
    model.run(StepController(0.05, 1e-6, 0.5, RADIUS), 2.0, newton=model.newton(2e-6))
    np.testing.assert_allclose(model.tension(), load, rtol=0.01)
    np.testing.assert_allclose(model.reaction("start"), load * DOWN, rtol=0.01, atol=0.01 * load)


def test_a_rod_spins_in_place_against_friction():
    """A rod on a cylinder of the same axis, spun on the spot, rubs with mu N across its axis."""
    points = line(10, 20.0)
    under = peg([0.0, 0.0, -RADIUS - 9.8], [1.0, 0.0, 0.0], CYLINDER, MU)
    model = begun(Rods([spec(points)], contact(), [under]))
    cylinder, friction, x = model.obstacle, model.obstacle_friction, model.x
    terms = [model.discrete.frames, cylinder, friction]
    f = np.zeros_like(x)
    for _ in range(8):
        x = x + 0.1 * RADIUS * np.eye(4)[3]
        f = np.zeros_like(x)
        for term in terms:
            term.update(x)
            term.assemble(x, f, None)
        for term in terms:
            term.commit(x)
    normal = cylinder.touch.force.sum()
    assert friction.sliding == cylinder.touching
    assert f[:, 1].sum() == pytest.approx(MU * normal, rel=1e-3)
    lever = (RADIUS - model.penetration) / RADIUS
    assert f[:, 3].sum() == pytest.approx(MU * normal * lever, rel=1e-6)
