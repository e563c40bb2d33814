"""Internal damping: what a rod that is deformed at a rate resists with."""

import numpy as np
import pytest
from derivatives import rotation
from reduced import (
    RADIUS,
    TWISTING,
    Rods,
    begin,
    begun,
    free_mass,
    line,
    residual,
    settle,
    spec,
    stiffness,
    tangent,
    tangent_error,
)
from verlet import verlet

import knotfem as kf
from knotfem.errors import InputError
from knotfem.mesh.rod_layout import RodLayout, make_layout
from knotfem.models.effects import DAMPING
from knotfem.models.rod.damping import BendDamping, Dashpot, StretchDamping, TwistDamping
from knotfem.models.rod.frames import Frames
from knotfem.run.check import check
from knotfem.solver.constraints import Clamp
from knotfem.solver.schemes import BackwardEuler, Scheme, hht
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.term import Role
from knotfem.terms.axial import AxialStiffness

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
        clamps = [Clamp(0, lambda time: (Q @ lean(time), Q[:, 2]))]
        self.frames.clamped_at(clamps, x, 0.0)
        self.dashpot = make(kind, self.layout, self.frames)
        self.dashpot.load(self.dashpot.at_rest(x, self.frames, {}))
        self.terms = [self.frames, self.dashpot]
        begin(self.terms, x, clamps)
        move = 0.2 * rng.normal(size=(8, 3))
        self.start, self.x = x, x.copy()
        self.x[:, :3] += move @ Q.T
        self.x[:, 3] = rng.normal(size=8)


def lean(time: float) -> np.ndarray:
    return np.array([np.cos(0.3 * time), np.sin(0.3 * time), 0.0])


def make(kind: type, layout: RodLayout, frames: Frames) -> Dashpot:
    """One whose stiffness over time is 90."""
    if kind is StretchDamping:
        edges = np.stack([layout.edges, layout.edges + 1], axis=1)
        ninety = np.full(len(edges), 90.0)
        stretch = AxialStiffness("stretch", edges, layout.spacing[layout.edges], ninety, ninety)
        return StretchDamping(stretch, np.ones(len(edges)))
    return kind(frames, np.array([90.0]))


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_tangent_is_that_of_the_residual(kind: type) -> None:
    moved = Moved(kind)
    if isinstance(moved.dashpot, StretchDamping):
        moved.dashpot.view.force[:] = moved.dashpot.tension(moved.x)
    assert tangent_error(moved.terms, moved.x) < 1e-7
    K = tangent(moved.terms, moved.x)
    np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_forces_balance_and_turn_with_the_rod(kind: type) -> None:
    Q = rotation()
    f, g = (residual(m.terms, m.x) for m in (Moved(kind), Moved(kind, Q)))
    assert np.abs(f).max() > 0.1
    np.testing.assert_allclose(f[:, :3].sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(g[:, :3], f[:, :3] @ Q.T, atol=1e-9)
    np.testing.assert_allclose(g[:, 3], f[:, 3], atol=1e-9)


@pytest.mark.parametrize("kind", [StretchDamping, BendDamping, TwistDamping])
def test_a_rod_that_moves_rigidly_resists_nothing(kind: type) -> None:
    moved, Q = Moved(kind), rotation()
    moved.frames.clamped_at([], moved.start, 0.0)
    moved.dashpot.load(moved.dashpot.at_rest(moved.start, moved.frames, {}))
    begin(moved.terms, moved.start)
    x = moved.start.copy()
    x[:, :3] = x[:, :3] @ Q.T + 3.0
    frames = moved.frames
    for j in range(7):
        t, d = (a[j] for a in frames.current(x))
        goal = frames.view.director[j] @ Q.T
        x[j, 3] = RADIUS * np.arctan2(np.cross(d, goal) @ t, d @ goal)
    np.testing.assert_allclose(residual(moved.terms, x), 0.0, atol=1e-11)


def test_a_bend_that_turns_through_the_section_is_resisted() -> None:
    """A bent rod that spins on the spot: its curvature changes direction in the section, not its size."""
    angle, h = 0.1, 1.0
    layout = make_layout([2], [h], [RADIUS])
    x = np.zeros((3, 4))
    x[:, 0], x[2, 1] = [0.0, h, h + h * np.cos(angle)], h * np.sin(angle)
    frames = Frames(layout, x, np.tile([0.0, 0.0, 1.0], (3, 1)))
    dashpot = make(BendDamping, layout, frames)
    dashpot.load(dashpot.at_rest(x, frames, {}))
    begin([frames, dashpot], x)
    x = x.copy()
    x[:2, 3] = 1e-3 * RADIUS
    couple = residual([frames, dashpot], x)[:2, 3] * RADIUS
    assert couple.sum() == pytest.approx(90.0 / h * angle**2 * 1e-3, rel=1e-2)


def cantilever(time: float, scheme: Scheme, segments: int = 12, length: float = 60.0) -> Rods:
    model = Rods([spec(line(segments, length), axial=200.0, relaxation_time=time)], scheme=scheme)
    return begun(model, model.clamped("start"))


def taken(model: Rods) -> float:
    """What internal damping has taken so far [N mm]."""
    return model.energies.taken[DAMPING.name]


def first_mode(model: Rods) -> tuple[float, np.ndarray]:
    """Frequency [rad/s] and shape, shape [nodes, 4], of the slowest bending in one plane."""
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
    damped, amplitude = omega * np.sqrt(1.0 - zeta**2), 0.01
    bent = amplitude * shape
    model.put(model.x + bent, -zeta * omega * bent, (zeta**2 - (1.0 - zeta**2)) * omega**2 * bent)
    model.begin(model.clamped("start"))
    period = 2.0 * np.pi / damped
    dt = period / 400
    stored, so_far, least = model.energies.stored, 0.0, np.inf
    for _ in model.steps(StepController(dt, dt, dt, 1e3), 2.0 * period, newton=model.newton(1e-10)):
        least, so_far = min(least, taken(model) - so_far), taken(model)
    mass = model.discrete.mass
    left = float(np.sum(model.x * shape * mass) / np.sum(amplitude * shape**2 * mass))
    assert -np.log(left) == pytest.approx(4.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2), rel=0.02)
    assert least >= 0.0
    assert taken(model) == pytest.approx(stored - model.energies.stored, rel=0.03)


def test_twisting_lags_by_the_relaxation_time() -> None:
    """A clamp that turns steadily meets C (tau dtheta/dt + theta)/L; what it meets at first jumps within a step."""
    length, rate = 60.0, 0.5
    model = Rods([spec(line(10, length), relaxation_time=TIME)], scheme=Scheme())
    turn = model.turned("end", AXIS, lambda t: rate * t)
    settle(model, model.clamped("start"), turn, duration=0.1, steps=10)
    e, twist = model.energies, model.discrete.twist.energy(model.x)
    assert twist == pytest.approx(0.5 * TWISTING / length * (0.1 * rate) ** 2, rel=1e-6)
    assert taken(model) == pytest.approx(TIME * TWISTING / length * rate**2 * 0.1, rel=1e-6)
    assert abs(e.algorithmic + e.error) < 0.51 * taken(model) / 10


def test_none_is_made_without_a_relaxation_time() -> None:
    assert not cantilever(0.0, BackwardEuler()).having(Dashpot)
    with_it = cantilever(TIME, BackwardEuler()).having(Dashpot)
    assert len(with_it) == 3
    assert all(term.name == DAMPING.name and term.role is Role.RESISTANCE and term.symmetric for term in with_it)


def test_it_goes_on_to_the_same_bits() -> None:
    def falling() -> Rods:
        gravity = np.array([0.0, 0.0, -9810.0])
        model = Rods([spec(line(12, 60.0), relaxation_time=TIME)], gravity=gravity, scheme=hht(-0.05))
        return begun(model, model.clamped("start"))

    def fall(model: Rods, stop: float) -> np.ndarray:
        model.run(StepController(1e-3, 1e-3, 1e-3, 1e3), stop, newton=model.newton(1e-8))
        return model.x

    first, second = falling(), falling()
    fall(first, 0.01)
    second.now = first.now
    np.testing.assert_array_equal(fall(second, 0.02), fall(first, 0.02))


def test_a_stretched_rod_creeps_like_a_spring_beside_a_dashpot() -> None:
    model = Rods([spec(line(5, 20.0), axial=200.0, relaxation_time=TIME)], scheme=Scheme())
    settle(model, model.clamped("start"), model.loaded("end", lambda t: 2.0 * AXIS), duration=TIME, steps=200)
    strain = (model.x[-1, 0] - 20.0) / 20.0
    assert strain == pytest.approx(0.01 * (1.0 - np.exp(-1.0)), rel=5e-3)


def test_explicit_steps_refuse_it() -> None:
    model = cantilever(TIME, Scheme())
    with pytest.raises(InputError, match="no internal damping"):
        next(verlet(model.system, model.state, model.discrete.mass, 1e-6, 1))


def test_a_scene_has_it_by_a_relaxation_time() -> None:
    overrides = [
        "rods.0.length=40 mm", "rods.0.mesh.element_length=4 mm", "steps.0.rate=real", "steps.0.duration=0.1 s",
        "output.fields=false", "inertia.scheme=backward-euler", f"rods.0.material.relaxation_time={TIME} s",
    ]  # fmt: skip
    with pytest.raises(InputError, match="relaxation_time: only the rod model has internal damping"):
        kf.load_scene("cantilever", overrides)
    scene = kf.load_scene("cantilever", [*overrides, "model=rod"])
    assert "B tau" in check(scene)["effects"][DAMPING.name]
    table = kf.pull(scene, progress=False).table("force")
    dissipated = table["internal_damping_Nmm"]
    assert np.all(np.diff(dissipated) >= 0.0)
    assert dissipated[-1] > 0.01 * table["elastic_Nmm"][-1]
