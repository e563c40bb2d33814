"""Internal damping: what a rod that is deformed at a rate resists with."""

import numpy as np
import pytest
from reduced import (
    RADIUS,
    TWISTING,
    begun,
    free_mass,
    line,
    residual,
    rotation,
    settle,
    spec,
    stiffness,
    tangent,
    tangent_error,
)

from knotfem.errors import InputError
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.damping import BendDamping, StretchDamping, TwistDamping
from knotfem.models.rod.ends import End, clamped, turned
from knotfem.models.rod.frames import Clamp, Frames
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.verlet import verlet
from knotfem.run import driver
from knotfem.run.check import check
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene
from knotfem.solver.schemes import BackwardEuler, Scheme, hht
from knotfem.solver.stepping.integrator import StepControl
from knotfem.terms.registry import INTERNAL_DAMPING

TIME = 0.02
AXIS = np.array([1.0, 0.0, 0.0])


class Moved:
    """A crooked rod, clamped at its start by a clamp that turns, at the end of a step in which all of it has moved."""

    def __init__(self, kind: type, turn: np.ndarray | None = None) -> None:
        rng, Q = np.random.default_rng(5), np.eye(3) if turn is None else turn
        self.layout = make_layout([7], [1.0], [RADIUS])
        x = np.zeros((8, 4))
        x[:, 0] = np.arange(8)
        x[:, :3] = (x[:, :3] + 0.25 * rng.normal(size=(8, 3))) @ Q.T
        self.frames = Frames(self.layout, x, rng.normal(size=(8, 3)) @ Q.T)
        self.frames.set_clamps([Clamp(0, lambda time: (Q @ lean(time), Q[:, 2]))], x, 0.0)
        self.effect = make(kind, self.layout, self.frames)
        self.effect.reset(x)
        self.effects = [self.frames, self.effect]
        begun(self.effects, x)
        move = 0.2 * rng.normal(size=(8, 3))
        self.start, self.x = x, x.copy()
        self.x[:, :3] += move @ Q.T
        self.x[:, 3] = rng.normal(size=8)


def lean(time: float) -> np.ndarray:
    return np.array([np.cos(0.3 * time), np.sin(0.3 * time), 0.0])


def make(kind: type, layout, frames):
    moduli = np.array([90.0])
    return kind(layout, moduli, moduli) if kind is StretchDamping else kind(frames, moduli)


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_tangent_is_that_of_the_residual(kind: type) -> None:
    moved = Moved(kind)
    if kind is StretchDamping:
        moved.effect.force = moved.effect.tension(moved.x)
    assert tangent_error(moved.effects, moved.x) < 1e-7
    K = tangent(moved.effects, moved.x)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_forces_balance_and_turn_with_the_rod(kind: type) -> None:
    Q = rotation()
    f, g = (residual(m.effects, m.x) for m in (Moved(kind), Moved(kind, Q)))
    assert np.abs(f).max() > 0.1
    np.testing.assert_allclose(f[:, :3].sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(g[:, :3], f[:, :3] @ Q.T, atol=1e-9)
    np.testing.assert_allclose(g[:, 3], f[:, 3], atol=1e-9)


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_a_rod_that_moves_rigidly_resists_nothing(kind: type) -> None:
    moved, Q = Moved(kind), rotation()
    moved.frames.set_clamps([], moved.start, 0.0)
    moved.effect.reset(moved.start)
    begun(moved.effects, moved.start)
    x = moved.start.copy()
    x[:, :3] = x[:, :3] @ Q.T + 3.0
    frames = moved.frames
    for j in range(7):
        t, d = (a[j] for a in frames.current(x))
        goal = frames.director0[j] @ Q.T
        x[j, 3] = RADIUS * np.arctan2(np.cross(d, goal) @ t, d @ goal)
    np.testing.assert_allclose(residual(moved.effects, x), 0.0, atol=1e-11)


def test_a_bend_that_turns_through_the_section_is_resisted() -> None:
    """A bent rod that spins on the spot: its curvature changes direction in the section, not its size."""
    angle, h = 0.1, 1.0
    layout = make_layout([2], [h], [RADIUS])
    x = np.zeros((3, 4))
    x[:, 0], x[2, 1] = [0.0, h, h + h * np.cos(angle)], h * np.sin(angle)
    frames = Frames(layout, x, np.tile([0.0, 0.0, 1.0], (3, 1)))
    effect = make(BendDamping, layout, frames)
    effect.reset(x)
    begun([frames, effect], x)
    x = x.copy()
    x[:2, 3] = 1e-3 * RADIUS
    torque = residual([frames, effect], x)[:2, 3] * RADIUS
    assert torque.sum() == pytest.approx(90.0 / h * angle**2 * 1e-3, rel=1e-2)


def cantilever(time: float, scheme: Scheme, segments: int = 12, length: float = 60.0) -> RodModel:
    model = RodModel([spec(line(segments, length), axial=200.0, relaxation_time=time)], scheme=scheme)
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
    return model


def first_mode(model: RodModel) -> tuple[float, np.ndarray]:
    """Frequency [rad/s] and shape, shape [nodes, 4], of the slowest bending in one plane."""
    assert model.system is not None
    root = np.sqrt(free_mass(model))
    values, vectors = np.linalg.eigh(stiffness(model) / np.outer(root, root))
    shape = np.zeros(model.x.size)
    shape[~model.system.fixed.ravel()] = vectors[:, 0] / root
    return float(np.sqrt(values[0])), shape.reshape(-1, 4) / np.linalg.norm(shape.reshape(-1, 4)[-1])


@pytest.mark.parametrize("zeta", [0.02, 0.1])
def test_a_cantilever_swings_out_at_half_its_relaxation_time_over_its_period(zeta: float) -> None:
    """zeta = tau omega/2: the amplitude falls by exp(-zeta omega t)."""
    omega, shape = first_mode(cantilever(0.0, Scheme()))
    model = cantilever(2.0 * zeta / omega, hht(0.0))
    motion, damped = model.progress.motion, omega * np.sqrt(1.0 - zeta**2)
    amplitude = 0.01
    motion.x[:] += amplitude * shape
    motion.v[:] = -zeta * omega * amplitude * shape
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
    motion.a[:] = (zeta**2 - (1.0 - zeta**2)) * omega**2 * amplitude * shape
    period = 2.0 * np.pi / damped
    dt = period / 400
    e = model.ledger.energies
    stored, least = e.stored, np.inf
    for _ in model.march(StepControl(dt, dt, dt, 1e3), model.settings(1e-10), [2.0 * period]):
        least = min(least, model.ledger.damping_step)
    left = float(np.sum(model.x * shape * model.mass) / np.sum(amplitude * shape**2 * model.mass))
    assert -np.log(left) == pytest.approx(4.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2), rel=0.02)
    assert least >= 0.0
    assert e.damping == pytest.approx(stored - e.stored, rel=0.03)


def test_twisting_lags_by_the_relaxation_time() -> None:
    """A clamp that turns steadily meets C (tau dtheta/dt + theta)/L; what it meets at first jumps within a step."""
    length, rate = 60.0, 0.5
    model = RodModel([spec(line(10, length), relaxation_time=TIME)], scheme=Scheme())
    turn = turned(model.end_frame(0, "end"), AXIS, lambda t: rate * t)
    settle(model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): turn}, duration=0.1, steps=10)
    e = model.ledger.energies
    assert e.twist == pytest.approx(0.5 * TWISTING / length * (0.1 * rate) ** 2, rel=1e-6)
    assert e.damping == pytest.approx(TIME * TWISTING / length * rate**2 * 0.1, rel=1e-6)
    assert abs(e.numerical) < 0.51 * e.damping / 10


def test_none_is_made_without_a_relaxation_time() -> None:
    assert INTERNAL_DAMPING not in {effect.name for effect in cantilever(0.0, BackwardEuler()).effects}
    with_it = [effect for effect in cantilever(TIME, BackwardEuler()).effects if effect.name == INTERNAL_DAMPING]
    assert len(with_it) == 3
    assert all(effect.viscous and effect.symmetric for effect in with_it)


def test_it_goes_on_to_the_same_bits() -> None:
    def falling() -> RodModel:
        gravity = np.array([0.0, 0.0, -9810.0])
        model = RodModel([spec(line(12, 60.0), relaxation_time=TIME)], gravity=gravity, scheme=hht(-0.05))
        model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
        return model

    def march(model: RodModel, stop: float) -> np.ndarray:
        for _ in model.march(StepControl(1e-3, 1e-3, 1e-3, 1e3), model.settings(1e-8), [stop]):
            pass
        return model.x.copy()

    first, second = falling(), falling()
    march(first, 0.01)
    second.load(first.history())
    np.testing.assert_array_equal(march(second, 0.02), march(first, 0.02))


def test_a_stretched_rod_creeps_like_a_spring_beside_a_dashpot() -> None:
    model = RodModel([spec(line(5, 20.0), axial=200.0, relaxation_time=TIME)], scheme=Scheme())
    ends = {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): End(force=lambda t: 2.0 * AXIS)}
    settle(model, ends, duration=TIME, steps=200)
    strain = (model.x[-1, 0] - 20.0) / 20.0
    assert strain == pytest.approx(0.01 * (1.0 - np.exp(-1.0)), rel=5e-3)


def test_explicit_steps_refuse_it() -> None:
    model = cantilever(TIME, Scheme())
    assert model.system is not None
    with pytest.raises(InputError, match="no internal damping"):
        next(verlet(model.system, model.progress.motion, model.mass, 1e-6, 1))


def test_a_scene_has_it_by_a_relaxation_time(tmp_path) -> None:
    overrides = [
        "rods.0.length=40 mm", "rods.0.mesh.element_length=4 mm", "drag=none", "steps.0.duration=0.1 s",
        "output.fields=false", "inertia.scheme=backward-euler", f"rods.0.material.relaxation_time={TIME} s",
    ]  # fmt: skip
    with pytest.raises(InputError, match="relaxation_time: only the rod model has internal damping"):
        load_scene("cantilever", overrides)
    scene = load_scene("cantilever", [*overrides, "model=rod"])
    assert "B tau" in check(scene)["effects"][INTERNAL_DAMPING]
    run = RunDirectory.create(scene, tmp_path / "run")
    driver.pull(scene, run)
    table = read_table(run.path / "force.csv")
    taken = table["internal_damping_Nmm"]
    assert np.all(np.diff(taken) >= 0.0)
    assert taken[-1] > 0.01 * table["elastic_Nmm"][-1]
