"""Implicit steps against explicit ones of the same rods."""

import numpy as np
import pytest
from reduced import RADIUS, contact, line, order, spec

from knotfem.errors import NotConverged
from knotfem.models.rod.ends import End, clamped
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.spec import CylinderSpec
from knotfem.models.rod.verlet import stable_step, verlet
from knotfem.solver.schemes import Scheme, hht
from knotfem.solver.stepping.integrator import StepControl

GRAVITY = np.array([0.0, 0.0, -9810.0])


def explicit(model: RodModel, duration: float, finer: int = 1) -> np.ndarray:
    assert model.system is not None
    motion = model.progress.motion
    steps = finer * int(np.ceil(duration / stable_step(model.system, motion, model.mass)))
    return list(verlet(model.system, motion, model.mass, duration / steps, steps))[-1].x


def implicit(model: RodModel, duration: float, steps: int) -> np.ndarray:
    """By the trapezoidal rule, from consistent accelerations."""
    assert model.system is not None
    inverse = np.where(model.system.fixed | (model.mass == 0.0), 0.0, 1.0 / np.maximum(model.mass, 1e-300))
    static = sum(model.ledger.forces.values(), np.zeros_like(model.x))
    model.progress.motion.a = -inverse * static
    dt = duration / steps
    for _ in model.march(StepControl(dt, 1e-3 * dt, dt, 1e3), model.settings(1e-8), [duration]):
        pass
    return model.x


def swinging(scheme: Scheme) -> RodModel:
    """A cantilever under a load that grows and goes again, with drag."""
    model = RodModel([spec(line(12, 60.0), axial=200.0)], drag=5.0, scheme=scheme)
    push = End(force=lambda t: np.array([0.0, 0.02, 0.05]) * np.sin(np.pi * t / 0.05) ** 2)
    model.begin({(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): push})
    return model


def test_a_swinging_cantilever():
    expected = explicit(swinging(Scheme()), 0.05)
    errors = [np.abs(implicit(swinging(hht(0.0)), 0.05, n) - expected).max() for n in (50, 100, 200)]
    sag = np.abs(expected[-1, 2])
    assert sag > 3.0
    assert errors[-1] < 1e-3 * sag
    assert order(errors) == pytest.approx(2.0, abs=0.2)


def dropping(scheme: Scheme) -> RodModel:
    """A short rod thrown upon a clamped one, across it and sideways, with friction."""
    beam = spec(line(12, 36.0), axial=200.0)
    stone = spec(line(4, 12.0, axis=1) + np.array([20.0, -5.0, 2 * RADIUS - 0.05]), axial=200.0)
    model = RodModel([beam, stone], contact(0.3), gravity=GRAVITY, drag=20.0, scheme=scheme)
    model.progress.motion.v[model.layout.of(1), :3] = [80.0, 0.0, -80.0]
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
    return model


def test_a_strand_thrown_on_another():
    model = dropping(Scheme())
    start = model.x.copy()
    expected = explicit(model, 0.02)
    assert model.friction is not None
    found = implicit(other := dropping(hht(0.0)), 0.02, 400)
    moved = np.abs(expected - start)[:, :3].max()
    assert moved > 1.0
    assert np.abs(found - expected)[:, :3].max() < 0.005 * moved
    assert other.ledger.energies.friction > 0.05 * 0.5 * other.mass[other.layout.of(1), 0].sum() * 2 * 80.0**2


def test_it_says_when_it_blows_up():
    model = swinging(Scheme())
    assert model.system is not None
    dt = 5.0 * stable_step(model.system, model.progress.motion, model.mass)
    with pytest.raises(NotConverged, match="shorter"), np.errstate(all="ignore"):
        for _ in verlet(model.system, model.progress.motion, model.mass, dt, 2000):
            pass


def test_the_stable_step_is_that_of_the_stiffest_part():
    """Of a chain of springs EA/h and masses m h: h sqrt(m/EA), of which Gershgorin's bound is a lower one."""
    model = swinging(Scheme())
    assert model.system is not None
    stiff = RodModel([spec(line(12, 60.0), axial=1e6)], scheme=Scheme())
    stiff.begin({})
    assert stiff.system is not None
    rod = stiff.rods[0]
    exact = 5.0 * np.sqrt(rod.mass_per_length / rod.axial)
    assert stable_step(stiff.system, stiff.progress.motion, stiff.mass) == pytest.approx(0.5 * exact, rel=0.05)


def rolling(scheme: Scheme) -> RodModel:
    """A twisted strand, clamped at its start, pressed on a rough cylinder and let go: it spins back and rolls."""
    peg = CylinderSpec(np.array([18.0, 0.0, -RADIUS - 9.95]), np.array([0.0, 1.0, 0.0]), 10.0, 0.3)
    model = RodModel([spec(line(12, 36.0), axial=200.0)], contact(), [peg], gravity=GRAVITY, drag=20.0, scheme=scheme)
    model.x[:, 3] = RADIUS * 0.6 * np.minimum(np.arange(13) + 0.5, 11.5) / 12.0
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
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
    assert other.ledger.energies.friction > 0.0
