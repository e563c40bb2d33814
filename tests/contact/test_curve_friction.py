"""Friction between discrete rods."""

import numpy as np
import pytest
from reduced import MASS, RADIUS, STICK, Rods, begun, contact, crossing, line, settle, spec

from knotfem.contact.mobilisation import mobilisation
from knotfem.solver.stepping.continuation import Continuation


def carried(model, x):
    """Take an accepted step of a second to x, whatever the forces; returns the friction on rod 1 at its end."""
    step = model.system.begin(model.state, 1.0)
    model.system.update(x)
    f = model.system.forces(x)["friction-1"]
    model.now = Continuation.at(model.system.commit(x, step))
    return -f[model.layout.of(1), :3].sum(axis=0)


def moved(model, rod, by, rotation=0.0):
    x = model.x.copy()
    x[model.layout.of(rod), :3] += by
    x[model.layout.of(rod), 3] += rotation * model.layout.radius[rod]
    return x


@pytest.mark.parametrize("place", [0.0, 0.5, 1.0, 1.37])
def test_sticking_force_has_no_jump_at_joints(place):
    """To and fro while the contact crosses nodes and middles of edges: one curve, as long as friction holds.

    Contact planes of the samples lean a little, so that the sum of the forces is less than that of their sizes.
    """
    model = crossing(0.6, shift=(0.0, 2.0 * place), friction=10.0)
    shifts = 0.2 * STICK * np.sin(np.linspace(0.0, 6.0, 25))
    forces = np.array([carried(model, moved(model, 1, [0.0, step, 0.0]))[1] for step in np.diff(shifts)])
    normal = model.contact.pairs.force.sum()
    law = [-10.0 * normal * np.sign(shift) * mobilisation(abs(shift) / STICK)[0] for shift in shifts[1:]]
    share = np.dot(forces, law) / np.dot(law, law)
    assert share == pytest.approx(1.0, rel=0.03)
    np.testing.assert_allclose(forces, share * np.array(law), atol=2e-3 * np.abs(forces).max())


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_sliding_force_is_mu_n_against_the_motion(direction):
    """Over several segments, in small and in large steps."""
    mu = 0.3
    for step in (0.05, 0.5):
        model = crossing(0.3, friction=mu)
        way, f = np.array([*direction, 0.0]), np.zeros(3)
        for _ in range(8):
            f = carried(model, moved(model, 1, step * way))
        normal = model.contact.pairs.force.sum()
        np.testing.assert_allclose(f[:2], -mu * normal * way[:2], atol=0.02 * mu * normal)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_friction_acts_where_a_strand_slides_by_more_than_a_radius_in_one_step(direction):
    """Contacts are found anew on the way; what friction remembers goes along, but for samples that were far apart."""
    mu, way = 0.3, np.array([*direction, 0.0])
    model, to, fro = crossing(0.3, friction=mu), 1.5 * RADIUS * way, -1.5 * RADIUS * way
    carried(model, model.x)
    for by in (to, fro, fro, to):
        f = carried(model, moved(model, 1, by))
        normal = model.contact.pairs.force.sum()
        np.testing.assert_allclose(f, -mu * normal * by / (1.5 * RADIUS), atol=0.15 * mu * normal)


@pytest.mark.parametrize(("way", "expected"), [(0.5 * STICK, 0.0), (5.0 * STICK, 4.0)])
def test_to_and_fro_takes_work_where_contacts_slide(way, expected):
    """Once round: nothing within the stick distance, mu N times the way that sliding makes beyond it."""
    mu, steps = 0.3, 400
    model, before, taken = crossing(0.3, friction=mu), 0.0, []
    for shift in np.diff(way * np.sin(np.linspace(0.0, 4.0 * np.pi, 2 * steps + 1))):
        force = carried(model, moved(model, 1, [shift, 0.0, 0.0]))[0]
        taken.append(-0.5 * (before + force) * shift)
        before = force
    normal = model.contact.pairs.force.sum()
    slides = 4.0 * (way - STICK) if expected else 0.0
    assert sum(taken[steps:]) == pytest.approx(mu * normal * slides, rel=0.15, abs=1e-5 * mu * normal * way)


def test_spinning_strand_rubs():
    """A strand that spins on the spot slides across its axis."""
    model, f = crossing(0.3, friction=0.3), np.zeros(3)
    for _ in range(6):
        f = carried(model, moved(model, 1, np.zeros(3), rotation=0.1))
    normal = model.contact.pairs.force.sum()
    np.testing.assert_allclose(f, [0.3 * normal, 0.0, 0.0], atol=0.02 * normal)


@pytest.mark.parametrize(
    ("step", "radius"), [(0.02, RADIUS), (0.1, RADIUS), (0.02, 0.5 * RADIUS), (0.02, 1.5 * RADIUS)]
)
def test_rolling_does_not_slip(step, radius):
    """A strand rolls round another: while its centre turns by beta, it spins by beta (1 + the ratio of their radii).

    Of unlike ones the chords differ from the arcs, by a third power of the step.
    """
    points = line(10, 20.0, axis=1)
    depth = RADIUS + radius - 0.2
    rods = [spec(points), spec(points + np.array([0.0, 0.0, depth]), radius=radius)]
    model = begun(Rods(rods, contact(friction=0.3)))
    beta, f = 0.0, np.zeros(3)
    for _ in range(int(1.0 / step)):
        beta += step
        x = model.x.copy()
        x[model.layout.of(1), 0], x[model.layout.of(1), 2] = depth * np.sin(beta), depth * np.cos(beta)
        x[model.layout.of(1), 3] += (1.0 + RADIUS / radius) * step * radius
        f = carried(model, x)
    slip = np.linalg.norm(model.friction.view.stored[model.contact.pairs.force > 0.0], axis=1).max()
    assert slip < 0.02 * STICK
    assert np.linalg.norm(f) < 0.02 * 0.3 * model.contact.pairs.force.sum()


def test_rigid_motion_does_not_slip():
    model = crossing(0.3, friction=0.3)
    carried(model, moved(model, 1, [0.02, 0.01, 0.0]))
    before = model.friction.view.stored.copy()
    turned = model.x.copy()
    c, s = np.cos(0.4), np.sin(0.4)
    turned[:, :3] = model.x[:, :3] @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T + [1.0, 2.0, 3.0]
    carried(model, turned)
    np.testing.assert_allclose(model.friction.view.stored, before, atol=1e-12)


def sleeper(slope, friction, *, drag):
    """A stiff rod along a slope, across two fixed ones, that does not roll; gravity leans by the slope."""
    angle, gravity = np.arctan(slope), 9810.0
    rods = [spec(line(40, 80.0) - np.array([40.0, 0.0, -2 * RADIUS]), bending=1e5)]
    rods += [spec(line(10, 20.0, axis=1) + np.array([x, -10.0, 0.0])) for x in (-20.0, 20.0)]
    lean = gravity * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    model = Rods(rods, contact(friction), gravity=lean, drag=drag)
    fixed = np.ones((model.layout.nodes, 4), dtype=bool)
    fixed[model.layout.of(0), :3] = False
    return model, fixed


def hold(steps):
    """Drift in so many steps at 90 % of the limit, and the elastic slip [mm]."""
    mu = 0.3
    model, fixed = sleeper(0.9 * mu, mu, drag=50.0)
    settle(model, duration=0.6, steps=300, tolerance=1e-8, fixed=fixed)
    before = model.x[:, :3].copy()
    c = model.contacts()
    assert np.sum(c.friction_force) / np.sum(c.normal_force) == pytest.approx(0.9 * mu, rel=0.02)
    settle(model, duration=0.001 * steps, steps=steps, tolerance=1e-8, fixed=fixed)
    slip = np.linalg.norm(model.friction.view.stored, axis=1).max()
    return np.abs(model.x[:, :3] - before).max(), slip


def test_a_sleeper_holds():
    drift, slip = hold(100)
    assert drift < 1e-5 * slip


@pytest.mark.slow
def test_a_sleeper_holds_ten_thousand_steps():
    drift, slip = hold(10_000)
    assert drift < 1e-3 * slip


def test_a_sleeper_slides_beyond_the_limit():
    mu, slope = 0.3, 0.5
    model, fixed = sleeper(slope, mu, drag=100.0)
    settle(
        model, duration=0.3, steps=100, tolerance=1e-8, fixed=fixed, friction=lambda time: 3.0 if time < 0.3 else 1.0
    )
    speeds, times = [], []
    for _ in range(12):
        settle(model, duration=0.005, steps=5, tolerance=1e-8, fixed=fixed, drag=0.0)
        times.append(model.time)
        speeds.append(model.state.v[model.layout.of(0), 0].mean())
    angle = np.arctan(slope)
    expected = 9810.0 * (np.sin(angle) - mu * np.cos(angle))
    assert np.polyfit(times, speeds, 1)[0] == pytest.approx(expected, rel=0.01)


def test_friction_follows_its_schedule():
    model = crossing(0.3, friction=0.4)
    model.begin(friction=lambda time: 0.5 if time > 1.5 else 1.0)
    step = model.system.begin(model.state, 1.0)
    np.testing.assert_allclose(model.friction.mu, 0.4)
    later = model.system.commit(model.x, step)
    model.system.begin(later, 1.0)
    np.testing.assert_allclose(model.friction.mu, 0.2)


def test_masses_are_those_of_the_rods():
    model, _ = sleeper(0.1, 0.3, drag=0.0)
    assert model.discrete.mass[:, 0].sum() == pytest.approx(MASS * 120.0)
    assert model.discrete.mass[:, 3].sum() == pytest.approx(0.5 * MASS * 120.0)
