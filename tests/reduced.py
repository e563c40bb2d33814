"""Small reduced models and checks that the tests of the rod model share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from knotfem.contact.curve_contact import hertz_line_stiffness
from knotfem.models.rod.ends import End
from knotfem.models.rod.model import RodModel, Side
from knotfem.models.rod.spec import ContactSpec, RodSpec
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import StepControl
from knotfem.solver.term import Motion, StepStart, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import RodPattern

YOUNGS, RADIUS = 1.425, 3.0
BENDING, TWISTING = YOUNGS * np.pi * RADIUS**4 / 4.0, YOUNGS * np.pi * RADIUS**4 / 6.0
MASS = 1.16e-9 * np.pi * RADIUS**2
RUBBER = hertz_line_stiffness(YOUNGS, 0.5)
Array = np.ndarray


def line(segments: int, length: float, axis: int = 0) -> Array:
    """Nodes of a straight rod from the origin along an axis."""
    points = np.zeros((segments + 1, 3))
    points[:, axis] = np.linspace(0.0, length, segments + 1)
    return points


def spec(points: Array, **changed) -> RodSpec:
    """A rubber rod without core, unless changed."""
    values = {"radius": RADIUS, "bending": BENDING, "twisting": TWISTING, "axial": 4e3, "mass_per_length": MASS}
    return RodSpec(points, **{**values, **changed})


def contact(friction: float | Array = 0.0, stiffness: float = RUBBER, **changed) -> ContactSpec:
    """Contact by Hertz's law in the default resolution."""
    return ContactSpec(stiffness, friction, ramp=RADIUS / 30.0, sample_spacing=RADIUS / 4.0, **changed)


def still(points: Array, **changed) -> RodModel:
    """One rod without inertia, drag and contact."""
    return RodModel([spec(points, **changed)], scheme=Scheme())


def crossing(
    depth: float,
    *,
    angle: float = np.pi / 2,
    shift: tuple[float, float] = (0.0, 0.0),
    segments: int = 20,
    h: float = 2.0,
    turn: Array | None = None,
    **changed,
) -> RodModel:
    """Two straight rods that cross, the second on top and pressed in by `depth`."""
    s = (np.arange(segments + 1) - segments / 2) * h
    lower = np.stack([s + shift[0], 0 * s, 0 * s], axis=1)
    upper = np.stack(
        [np.cos(angle) * (s + shift[1]), np.sin(angle) * (s + shift[1]), 0 * s + 2 * RADIUS - depth], axis=1
    )
    Q = np.eye(3) if turn is None else turn
    model = RodModel([spec(lower @ Q.T), spec(upper @ Q.T)], contact(**changed))
    model.begin({})
    return model


def settle(
    model: RodModel,
    ends: Mapping[Side, End],
    *,
    duration: float = 1.0,
    steps: int = 4,
    tolerance: float = 2e-8,
    move: float = 1e3,
    frozen: Array | None = None,
) -> int:
    """March through one phase in equal steps; returns the iterations taken."""
    model.begin(ends, frozen)
    dt = duration / steps
    control = StepControl(first=dt, smallest=1e-4 * dt, largest=dt, move=move)
    settings = NewtonSettings(tolerance, 10.0 * tolerance, 60, move, 0.03 if move < 1e3 else 1e3)
    return sum(step.took.count for step in model.march(control, settings, [model.time + duration]))


def stiffness(model: RodModel) -> Array:
    """Dense tangent of the free unknowns at the present state."""
    system = model.system
    assert system is not None
    system.update(model.x)
    system.begin(StepStart(model.progress.motion, 1e-9))
    free = ~system.fixed.ravel()
    return system.tangent(model.x)[1].to_scipy().toarray()[np.ix_(free, free)]


def free_mass(model: RodModel) -> Array:
    """Mass of the free unknowns."""
    assert model.system is not None
    return model.mass.ravel()[~model.system.fixed.ravel()]


def begun(effects: Sequence[Term], x: Array) -> None:
    """Effects at the start of a step from rest at x."""
    for effect in effects:
        effect.update(x)
    for effect in effects:
        effect.begin(StepStart(Motion.at_rest(x), 1.0))


def residual(effects: Sequence[Term], x: Array) -> Array:
    """Residual of the last effect; all are updated in order."""
    for effect in effects:
        effect.update(x)
    result = np.zeros_like(x)
    assert effects[-1].assemble(x, result, None)
    return result


def tangent(effects: Sequence[Term], x: Array) -> Array:
    """Dense tangent of the last effect through the sparsity of all."""
    for effect in effects:
        effect.update(x)
    count = len(x)
    keys = [np.arange(count) * (count + 1)] + [k for e in effects if (k := e.couplings(count)) is not None]
    matrix = Matrix(RodPattern.from_keys(np.unique(np.concatenate(keys)), count, False))
    assert effects[-1].assemble(x, np.zeros_like(x), matrix), "the keys do not cover the tangent"
    return matrix.to_scipy().toarray()


def differences(effects: Sequence[Term], x: Array, step: float = 1e-6) -> Array:
    """Central differences of the residual, column by column."""
    columns = np.empty((x.size, x.size))
    for k in range(x.size):
        sides = []
        for sign in (1.0, -1.0):
            y = x.copy().ravel()
            y[k] += sign * step
            sides.append(residual(effects, y.reshape(x.shape)).ravel())
        columns[:, k] = (sides[0] - sides[1]) / (2.0 * step)
    return columns


def tangent_error(effects: Sequence[Term], x: Array) -> float:
    """Largest deviation of the tangent from central differences, over its largest entry."""
    expected = differences(effects, x)
    return float(np.abs(tangent(effects, x) - expected).max() / np.abs(expected).max())


def gradient_error(effects: Sequence[Term], x: Array, step: float = 1e-6) -> float:
    """Largest deviation of the last effect's residual from central differences of its energy, relative."""
    force = residual(effects, x)
    slope = np.empty(x.size)
    for k in range(x.size):
        sides = []
        for sign in (1.0, -1.0):
            y = x.copy().ravel()
            y[k] += sign * step
            y = y.reshape(x.shape)
            for effect in effects:
                effect.update(y)
            sides.append(effects[-1].energy(y))
        slope[k] = (sides[0] - sides[1]) / (2.0 * step)
    return float(np.abs(force.ravel() - slope).max() / np.abs(force).max())


def rotation(seed: int = 7) -> Array:
    """A proper rotation far from the identity."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def order(errors: Sequence[float]) -> float:
    """Measured order of convergence of errors under halving."""
    return float(np.log2(errors[0] / errors[-1]) / (len(errors) - 1))
