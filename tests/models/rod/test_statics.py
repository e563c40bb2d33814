"""Rods without contact against closed forms and solved boundary value problems."""

import numpy as np
import pytest
from reduced import (
    BENDING,
    MASS,
    SIDES,
    TWISTING,
    Rods,
    free_mass,
    graded_line,
    line,
    order,
    settle,
    spec,
    stiffness,
    still,
)

from knotfem.solver.schemes import Scheme

LENGTH = 100.0
X = np.array([1.0, 0.0, 0.0])
ELASTICA = {1.0: (0.46135, 0.05643, 0.30172), 5.0: (1.21537, 0.38763, 0.71379)}
"""Tip slope, shortening and sag under the dead tip load a = P L^2/EI (Bisshopp and Drucker 1945)."""


def straight(segments: int, graded: bool) -> Rods:
    """A straight rod of segments of one length, or of unequal ones."""
    if not graded:
        return still(line(segments, LENGTH))
    points, spacing = graded_line(segments, LENGTH)
    return still(points, spacing=spacing)


def elastica(a: float, segments: int, graded: bool = False) -> np.ndarray:
    model = straight(segments, graded)
    force = np.array([0.0, 0.0, -a * BENDING / LENGTH**2])
    settle(model, model.clamped("start"), model.loaded("end", lambda t: min(t, 1.0) * force))
    last = model.x[-1] - model.x[-2]
    return np.array([np.arctan2(-last[2], last[0]), 1.0 - model.x[-1, 0] / LENGTH, -model.x[-1, 2] / LENGTH])


@pytest.mark.parametrize("graded", [False, True])
@pytest.mark.parametrize("a", [1.0, 5.0])
def test_elastica(a, graded):
    np.testing.assert_allclose(elastica(a, 80, graded), ELASTICA[a], rtol=2e-3 if graded else 1e-3)
    fine = elastica(a, 320, graded)
    errors = [np.abs(elastica(a, n, graded) - fine).max() for n in (10, 20, 40)]
    assert order(errors) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(("gamma", "sag"), [(1.0, 0.12347), (5.0, 0.49591), (10.0, 0.70020)])
def test_heavy_cantilever(gamma, sag):
    length = (gamma * BENDING / (MASS * 9810.0)) ** (1 / 3)
    model = Rods([spec(line(80, length))], gravity=np.array([0.0, 0.0, -9810.0]), scheme=Scheme())
    settle(model, model.clamped("start"))
    assert -model.x[-1, 2] / length == pytest.approx(sag, rel=1e-3)


@pytest.mark.parametrize("graded", [False, True])
def test_roll_up(graded):
    """An arc is exact in any number of segments: M = 2 pi B/L closes the circle, all but the gap of unequal chords."""
    model = straight(12, graded)
    roll = model.turned("end", np.array([0.0, 1.0, 0.0]), lambda t: -2.0 * np.pi * t, held=False)
    settle(model, model.clamped("start"), roll, steps=10)
    np.testing.assert_allclose(model.x[-1, :3], 0.0, atol=(0.1 if graded else 1e-6) * LENGTH)
    np.testing.assert_allclose(model.discrete.bend.curvature(model.x), 2.0 * np.pi / LENGTH, rtol=1e-6)
    couples = model.clamp_couples(model.x)
    np.testing.assert_allclose(couples[1], [0.0, -2.0 * np.pi * BENDING / LENGTH, 0.0], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(couples.sum(axis=0), 0.0, atol=1e-6)
    bend = model.discrete.bend.energy(model.x)
    assert bend == pytest.approx(2.0 * np.pi**2 * BENDING / LENGTH, rel=1e-6)
    assert model.energies.work == pytest.approx(bend, rel=1e-6)


def test_frequencies():
    exact = np.array([1.8751, 4.6941]) ** 2 * np.sqrt(BENDING / MASS) / LENGTH**2

    def found(segments):
        model = still(line(segments, LENGTH))
        model.begin(model.clamped("start"))
        root = np.sqrt(free_mass(model))
        K = stiffness(model) / np.outer(root, root)
        return np.sqrt(np.linalg.eigvalsh(K)[[0, 2]])

    np.testing.assert_allclose(found(80), exact, rtol=1e-3)
    fine = found(160)
    assert order([np.abs(found(n) / fine - 1.0).max() for n in (20, 40)]) == pytest.approx(2.0, abs=0.2)


def test_torsional_frequency():
    model = still(line(40, LENGTH))
    fixed = np.zeros((41, 4), dtype=bool)
    fixed[:, :3] = True
    model.begin(model.clamped("start"), fixed=fixed)
    root = np.sqrt(free_mass(model))
    lowest = np.sqrt(np.linalg.eigvalsh(stiffness(model) / np.outer(root, root))[0])
    inertia = 0.5 * MASS * 3.0**2
    assert lowest == pytest.approx(0.5 * np.pi / LENGTH * np.sqrt(TWISTING / inertia), rel=1e-3)


@pytest.mark.parametrize(("hold", "critical"), [(Rods.pinned, np.pi**2), (Rods.clamped, 4.0 * np.pi**2)])
def test_euler_buckling(hold, critical):
    def lowest(load, segments=60, axial=1e6):
        model = still(line(segments, LENGTH), axial=axial)
        model.put(x=model.x * [1.0 - load / axial, 1.0, 1.0, 1.0])
        model.begin(*(hold(model, side) for side in SIDES))
        moving = np.linalg.eigvalsh(stiffness(model))
        return moving[np.abs(moving) > 1e-8][0]

    load = critical * BENDING / LENGTH**2
    assert lowest(0.99 * load) > 0.0
    assert lowest(1.01 * load) < 0.0


@pytest.mark.parametrize("graded", [False, True])
def test_masses_are_those_of_the_segments(graded):
    model = straight(10, graded)
    mass, x = model.discrete.mass, model.x[:, 0]
    lengths, middles = np.diff(x), 0.5 * (x[1:] + x[:-1])
    np.testing.assert_allclose(mass[:, :3].sum(axis=0), MASS * LENGTH)
    assert mass[:, 0] @ x == pytest.approx(MASS * lengths @ middles)
    np.testing.assert_allclose(mass[:-1, 3], 0.5 * MASS * lengths)


@pytest.mark.parametrize("graded", [False, True])
def test_uniform_torsion(graded):
    model = straight(10, graded)
    settle(model, model.clamped("start"), model.turned("end", X, lambda t: 9.0 * t), steps=6)
    frames = model.discrete.frames
    np.testing.assert_allclose(model.discrete.torque(model.x), 9.0 * TWISTING / LENGTH, rtol=1e-9)
    np.testing.assert_allclose(frames.twists(model.x) / frames.cell, 9.0 / LENGTH, rtol=1e-9)
    assert model.energies.work == pytest.approx(0.5 * TWISTING * 81.0 / LENGTH, rel=1e-6)


def test_stretch():
    model = still(line(10, LENGTH), axial=50.0)
    settle(model, model.pinned("start"), model.loaded("end", lambda t: 5.0 * t * X))
    np.testing.assert_allclose(model.tension(), 5.0, rtol=1e-9)
    assert model.x[-1, 0] == pytest.approx(1.1 * LENGTH, rel=1e-9)
    np.testing.assert_allclose(model.reaction("start"), [-5.0, 0.0, 0.0], atol=1e-8)


@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_twisted_ring_leaves_its_plane(ratio):
    """Michell (1889): a ring joined with the twist Phi becomes unstable at Phi C/B = 2 pi sqrt(3).

    The lowest mode, of no stiffness at all, turns the whole ring about the tangent at the joint.
    """
    n, R = 48, 50.0
    phi = 2.0 * np.pi * np.arange(n + 1) / n
    points = np.stack([R * np.sin(phi), R * (1.0 - np.cos(phi)), 0.0 * phi], axis=1)
    critical = 2.0 * np.pi * np.sqrt(3.0) * ratio

    def unstable(twist):
        model = still(points, radius=1.0, bending=1.0, twisting=1.0 / ratio, axial=40.0)
        joint = model.turned("end", X, lambda t: twist * t)
        settle(model, model.clamped("start"), joint, steps=int(twist / 2) + 1, tolerance=1e-10)
        centred = model.x[:, :3] - model.x[:, :3].mean(axis=0)
        assert np.linalg.svd(centred)[1][2] < 0.05 * R, "left its plane on the way"
        return np.linalg.eigvalsh(stiffness(model))[1] < -1e-9

    assert not unstable(0.98 * critical)
    assert unstable(1.02 * critical)


def test_twisted_rod_buckles():
    """Greenhill (1883): a rod clamped at both ends, free to draw in, buckles at M L/B = 8.987, from tan(y/2) = y/2."""
    critical = 8.98682

    def lowest(torque):
        model = still(line(60, LENGTH), axial=1e5)
        twist = torque * BENDING / TWISTING
        settle(model, model.clamped("start"), model.turned("end", X, lambda t: twist * t), steps=6)
        np.testing.assert_allclose(model.discrete.torque(model.x), torque * BENDING / LENGTH, rtol=1e-9)
        return np.linalg.eigvalsh(stiffness(model))[0]

    assert lowest(0.99 * critical) > 0.0
    assert lowest(1.01 * critical) < 0.0
