"""Implicit steps against explicit ones of the same rods."""

import numpy as np
import pytest
from reduced import RADIUS, Rods, begun, contact, line, order, peg, spec, static_forces
from verlet import stable_step, verlet

from knotfem.errors import NotConverged
from knotfem.solver.schemes import Scheme, hht
from knotfem.solver.stepping.controller import StepController

GRAVITY = np.array([0.0, 0.0, -9810.0])


def explicit(model: Rods, duration: float) -> np.ndarray:
    system, state, mass = model.system, model.state, model.discrete.mass
    steps = int(np.ceil(duration / stable_step(system, state, mass)))
    return list(verlet(system, state, mass, duration / steps, steps))[-1].x


def implicit(model: Rods, duration: float, steps: int) -> np.ndarray:
    """By the trapezoidal rule, from consistent accelerations."""
    mass = model.discrete.mass
    inverse = np.where(model.system.fixed | (mass == 0.0), 0.0, 1.0 / np.maximum(mass, 1e-300))
    model.put(a=-inverse * static_forces(model))
    dt = duration / steps
    model.run(StepController(dt, 1e-3 * dt, dt, 1e3), duration, newton=model.newton(1e-8))
    return model.x


def swinging(scheme: Scheme) -> Rods:
    """A cantilever under a load that grows and goes again, with drag."""
    model = Rods([spec(line(12, 60.0), axial=200.0)], drag=5.0, scheme=scheme)
    push = model.loaded("end", lambda t: np.array([0.0, 0.02, 0.05]) * np.sin(np.pi * t / 0.05) ** 2)
    model.begin(model.clamped("start"), push)
    return model


def test_a_swinging_cantilever():
    expected = explicit(swinging(Scheme()), 0.05)
    errors = [np.abs(implicit(swinging(hht(0.0)), 0.05, n) - expected).max() for n in (50, 100, 200)]
    sag = np.abs(expected[-1, 2])
    assert sag > 3.0
    assert errors[-1] < 1e-3 * sag
    assert order(errors) == pytest.approx(2.0, abs=0.2)


def dropping(scheme: Scheme) -> Rods:
    """A short rod thrown upon a clamped one, across it and sideways, with friction."""
    beam = spec(line(12, 36.0), axial=200.0)
    stone = spec(line(4, 12.0, axis=1) + np.array([20.0, -5.0, 2 * RADIUS - 0.05]), axial=200.0)
    model = Rods([beam, stone], contact(0.3), gravity=GRAVITY, drag=20.0, scheme=scheme)
    v = np.zeros_like(model.x)
    v[model.layout.of(1), :3] = [80.0, 0.0, -80.0]
    model.put(v=v)
    model.begin(model.clamped("start"))
    return model


def test_a_strand_thrown_on_another():
    model = dropping(Scheme())
    start = model.x.copy()
    expected = explicit(model, 0.02)
    found = implicit(other := dropping(hht(0.0)), 0.02, 400)
    moved = np.abs(expected - start)[:, :3].max()
    assert moved > 1.0
    assert np.abs(found - expected)[:, :3].max() < 0.005 * moved
    assert other.energies.friction > 0.05 * 0.5 * other.discrete.mass[other.layout.of(1), 0].sum() * 2 * 80.0**2


def test_it_says_when_it_blows_up():
    model = swinging(Scheme())
    system, state, mass = model.system, model.state, model.discrete.mass
    dt = 5.0 * stable_step(system, state, mass)
    with pytest.raises(NotConverged, match="shorter"), np.errstate(all="ignore"):
        for _ in verlet(system, state, mass, dt, 2000):
            pass


def test_the_stable_step_is_that_of_the_stiffest_part():
    """Of a chain of springs EA/h and masses m h: h sqrt(m/EA), of which Gershgorin's bound is a lower one."""
    rod = spec(line(12, 60.0), axial=1e6)
    stiff = begun(Rods([rod], scheme=Scheme()))
    exact = 5.0 * np.sqrt(rod.mass_per_length / rod.axial)
    assert stable_step(stiff.system, stiff.state, stiff.discrete.mass) == pytest.approx(0.5 * exact, rel=0.05)


def rolling(scheme: Scheme) -> Rods:
    """A twisted strand, clamped at its start, pressed on a rough cylinder and let go: it spins back and rolls."""
    rough = peg([18.0, 0.0, -RADIUS - 9.95], [0.0, 1.0, 0.0], 10.0, 0.3)
    model = Rods([spec(line(12, 36.0), axial=200.0)], contact(), [rough], gravity=GRAVITY, drag=20.0, scheme=scheme)
    x = model.x.copy()
    x[:, 3] = RADIUS * 0.6 * np.minimum(np.arange(13) + 0.5, 11.5) / 12.0
    start = model.clamped("start")
    model.put(x=x)
    model.begin(start)
    return model


def test_a_twisted_strand_that_spins_back_on_a_rough_cylinder():
    model = rolling(Scheme())
    start = model.x.copy()
    expected = explicit(model, 0.004)
    found = implicit(other := rolling(hht(0.0)), 0.004, 200)
    moved = np.abs(expected - start)
    assert moved[:, 3].max() > 1.0
    assert moved[:, :3].max() > 0.05
    assert np.abs(found - expected)[:, 3].max() < 0.01 * moved[:, 3].max()
    assert np.abs(found - expected)[:, :3].max() < 0.01 * moved[:, :3].max()
    assert other.energies.friction > 0.0
