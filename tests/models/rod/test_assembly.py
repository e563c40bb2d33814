"""Discrete rods as a whole: they go on from a state, turn with the scene, and heed their ends."""

import numpy as np
import pytest
from derivatives import rotation
from reduced import BENDING, RADIUS, SIDES, Rods, begun, contact, crossing, line, peg, settle, spec, still

import knotfem as kf
from knotfem.errors import InputError
from knotfem.geometry.frames import tangents
from knotfem.models.base import RigidMotion
from knotfem.models.newton import newton_of
from knotfem.models.rod.model import RodModel
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.term import Conditions

CONTROL = StepController(0.01, 1e-6, 0.05, RADIUS)


def loaded() -> Rods:
    """A strand pressed on another and on a cylinder, slipping."""
    lower = line(12, 36.0) - np.array([18.0, 0.0, 0.0])
    upper = line(12, 36.0, axis=1) + np.array([0.0, -18.0, 2 * RADIUS - 0.1])
    below = peg([0.0, 0.0, -10.0 - RADIUS], [0.0, 1.0, 0.0], 10.0, 0.2)
    gravity = np.array([0.0, 0.0, -9810.0])
    model = Rods([spec(lower), spec(upper)], contact(0.3), [below], gravity=gravity, drag=20.0)
    press = model.loaded("end", lambda t: np.array([0.06 * t, 0.02 * t, -0.05]), rod=1)
    return begun(model, model.clamped("start"), model.pinned("start", rod=1), press)


def test_goes_on_from_a_state_to_the_last_bit():
    whole, other = loaded(), loaded()
    steps = whole.steps(CONTROL, 0.5)
    for _ in range(12):
        next(steps)
    now, balance, keys = whole.now, whole.balance.state(), whole.system.keys
    rest = sum(1 for _ in steps)
    other.now = now
    other.balance.restore(balance)
    other.system.load(now.state)
    other.system.update(now.state.x)
    assert keys is not None
    other.system.restore_pattern(keys)
    assert sum(1 for _ in other.steps(CONTROL, 0.5)) == rest
    assert whole.energies.friction > 0.1 * whole.energies.elastic
    np.testing.assert_array_equal(other.x, whole.x)
    np.testing.assert_array_equal(other.friction.view.stored, whole.friction.view.stored)
    assert other.energies == whole.energies


def test_a_state_never_changes():
    """The rods go on from it twice, the second time with the same terms, and come to the same end."""
    model = loaded()
    start, kept = model.now, {name: array.copy() for name, array in model.state.history["frames-1"].items()}
    x = start.state.x.copy()
    model.run(CONTROL, 0.2)
    once, stored = model.x, model.friction.view.stored
    np.testing.assert_array_equal(start.state.x, x)
    for name, array in kept.items():
        np.testing.assert_array_equal(start.state.history["frames-1"][name], array)
    model.now = start
    model.system.drop_pattern()
    model.run(CONTROL, 0.2)
    assert np.abs(once - x).max() > 0.01
    np.testing.assert_allclose(model.x, once, atol=1e-9)
    np.testing.assert_allclose(model.friction.view.stored, stored, atol=1e-9)


def test_the_result_turns_and_mirrors_with_the_scene():
    def bent(Q):
        model = still(line(12, 60.0) @ Q.T)
        push = Q @ np.array([-0.02, 0.015, 0.03])
        settle(model, model.clamped("start"), model.loaded("end", lambda t: min(t, 1.0) * push))
        return model.centreline()

    plain = bent(np.eye(3))
    assert np.abs(plain[-1] - [60.0, 0.0, 0.0]).max() > 5.0
    for Q in (rotation(), np.diag([1.0, 1.0, -1.0])):
        np.testing.assert_allclose(bent(Q), plain @ Q.T, atol=1e-6)


def test_a_following_force_keeps_its_direction_to_the_rod():
    """Beck's column well below flutter stays straight; across it, the reaction is the load along the end."""
    model = still(line(12, 60.0))
    settle(model, model.clamped("start"), model.followed("end", lambda t: -0.01 * min(t, 1.0)))
    np.testing.assert_allclose(model.centreline()[:, 1:], 0.0, atol=1e-12)
    np.testing.assert_allclose(model.reaction("start"), [0.01, 0.0, 0.0], atol=1e-7)


def test_a_following_force_on_a_rod_that_turns_far_costs_few_iterations():
    """The line search weighs it, and lets steps through: 126 iterations, where 685 are taken without it."""
    model = still(line(20, 60.0))
    turn = model.turned("start", np.array([0.0, 0.0, 1.0]), lambda t: 2.0 * t)
    push = model.followed("end", lambda t: -0.5 * min(t, 1.0))
    assert settle(model, turn, push, steps=8, move=RADIUS) < 200


def test_a_driven_end_goes_where_it_is_told():
    model = still(line(12, 60.0))
    settle(model, model.clamped("start"), model.driven("end", np.array([0.0, 0.0, 1.0]), lambda t: 0.05 * t))
    np.testing.assert_allclose(model.x[-1, :3], [60.0, 0.0, 0.05], atol=1e-12)
    deflection = model.reaction("end")[2] * 60.0**3 / (12.0 * BENDING)
    assert deflection == pytest.approx(0.05, rel=0.01)


def test_an_end_is_clamped_as_the_curve_lies_before_the_first_step_and_as_its_clamp_has_turned_after(tmp_path):
    phi = np.linspace(0.0, 1.0, 401)
    arc = 50.0 * np.stack([np.sin(phi), 1.0 - np.cos(phi), 0.0 * phi], axis=1)
    np.savetxt(tmp_path / "arc.csv", arc, delimiter=",", header="x,y,z", comments="")
    overrides = {"model": "rod", "rods.0.centerline": str(tmp_path / "arc.csv"), "rods.0.length": "50 mm"}
    model = RodModel(kf.load_scene("cantilever", {**overrides, "rods.0.smoothing.iterations": 0}))
    state = model.straight()
    motion = RigidMotion(rotation=lambda time: 0.5 * time)
    held, (clamp,) = model.constrained(0, "end", motion, state)
    tangent, director = clamp.orientation(0.0)
    np.testing.assert_allclose(tangent, tangents(model.targets[0].points)[-1], atol=1e-12)
    np.testing.assert_allclose(tangent, [np.cos(1.0), np.sin(1.0), 0.0], atol=1e-3)
    assert tangent @ director == pytest.approx(0.0, abs=1e-12)
    state = model.discrete.clamped(state, [clamp])
    system = model.discrete.system(Scheme(), [held], conditions=Conditions(clamps=[clamp]))
    after = system.commit(state.x, system.begin(state, 1.0))
    (again,) = model.constrained(0, "end", RigidMotion(), after)[1]
    np.testing.assert_array_equal(again.orientation(5.0)[0], tangent)
    np.testing.assert_array_equal(again.orientation(5.0)[1], clamp.orientation(1.0)[1])
    assert director @ again.orientation(5.0)[1] == pytest.approx(np.cos(0.5))


def test_clamping_a_rod_as_it_lies_does_not_twist_it():
    phi = np.linspace(0.0, 7.0, 71)
    helix = np.stack([20.0 * np.cos(phi), 20.0 * np.sin(phi), 4.0 * phi], axis=1)
    model = still(helix)
    model.begin(*(model.clamped(side) for side in SIDES))
    np.testing.assert_allclose(model.discrete.torque(model.x), 0.0, atol=1e-9)


def test_fixed_places_let_the_twist_go():
    model = still(line(20, 60.0))
    x, start = model.x.copy(), model.clamped("start")
    x[:, 3] = RADIUS * np.linspace(0.0, 4.0, 21) ** 2
    model.put(x=x)
    fixed = np.zeros((21, 4), dtype=bool)
    fixed[:, :3] = True
    settle(model, start, fixed=fixed)
    frames = model.discrete.frames
    np.testing.assert_allclose(frames.twists(model.x) / frames.cell, 0.0, atol=1e-9)
    np.testing.assert_allclose(model.centreline(), line(20, 60.0), atol=0.0)


def test_a_step_that_whips_a_node_away_is_rejected():
    model = Rods([spec(line(10, 60.0))], drag=1.0)
    model.begin(model.clamped("start"), model.loaded("end", lambda t: np.array([0.0, 0.0, 5.0])))
    moves, rejected = [], 0
    for step in model.steps(StepController(0.05, 1e-6, 0.05, RADIUS), 0.05):
        moves.append(np.abs(step.state.x - step.start.x)[:, :3].max())
        rejected += step.rejected
        assert not step.rejected or "moved by" in step.failure
    assert rejected > 0
    assert max(moves) <= 1.5 * RADIUS


def test_wrong_input():
    straight = line(4, 8.0)
    with pytest.raises(InputError, match="at least 2"):
        Rods([spec(line(1, 8.0))])
    with pytest.raises(InputError, match="obstacles need contact"):
        Rods([spec(straight)], None, [peg([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 10.0, 0.2)])
    with pytest.raises(InputError, match=r"\(4, 3\)"):
        Rods([spec(straight, directors=np.zeros((5, 3)))])


def test_newtons_method_scales_with_the_rod():
    thin, thick = (
        newton_of(RodModel(kf.load_scene("cantilever", {"model": "rod", "rods.0.diameter": f"{d} mm"}))) for d in (1, 6)
    )
    assert thin.largest_move == pytest.approx(thick.largest_move / 6.0)
    assert thin.line_search.whole_below == pytest.approx(thick.line_search.whole_below / 6.0)


def test_no_penetration_without_contact():
    model = begun(still(line(4, 8.0)))
    assert model.penetration == 0.0
    assert model.contacts().rod.size == 0
    assert crossing(0.25).penetration == pytest.approx(0.25, abs=0.05)
