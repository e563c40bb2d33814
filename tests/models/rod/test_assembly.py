import numpy as np
import pytest
from reduced import RADIUS, contact, crossing, line, rotation, settle, spec, still

from knotfem.errors import InputError
from knotfem.models.rod.ends import End, clamped, driven, pinned, turned
from knotfem.models.rod.model import RodModel
from knotfem.models.rod.spec import CylinderSpec
from knotfem.solver.schemes import Scheme
from knotfem.solver.stepping.integrator import StepControl

CONTROL = StepControl(0.01, 1e-6, 0.05, RADIUS)


def loaded() -> RodModel:
    """A strand pressed on another and on a cylinder, slipping."""
    lower = line(12, 36.0) - np.array([18.0, 0.0, 0.0])
    upper = line(12, 36.0, axis=1) + np.array([0.0, -18.0, 2 * RADIUS - 0.1])
    below = CylinderSpec(np.array([0.0, 0.0, -10.0 - RADIUS]), np.array([0.0, 1.0, 0.0]), 10.0, 0.2)
    gravity = np.array([0.0, 0.0, -9810.0])
    return RodModel([spec(lower), spec(upper)], contact(0.3), [below], gravity=gravity, drag=20.0)


def begin(model: RodModel, frames) -> None:
    press = End(force=lambda t: np.array([0.06 * t, 0.02 * t, -0.05]))
    model.begin({(0, "start"): clamped(frames[0]), (1, "start"): pinned(frames[1]), (1, "end"): press})


def test_goes_on_from_a_memory_to_the_last_bit():
    whole = loaded()
    frames = [whole.end_frame(rod, "start") for rod in (0, 1)]
    begin(whole, frames)
    march = whole.march(CONTROL, whole.settings(), [0.5])
    for _ in range(12):
        next(march)
    history = whole.history()
    for _ in march:
        pass
    other = loaded()
    begin(other, frames)
    other.load(history)
    for _ in other.march(CONTROL, other.settings(), [0.5]):
        pass
    assert whole.friction is not None
    assert whole.ledger.energies.friction > 0.1 * whole.ledger.energies.elastic
    np.testing.assert_array_equal(other.x, whole.x)
    np.testing.assert_array_equal(other.friction.stored, whole.friction.stored)
    assert other.ledger.energies == whole.ledger.energies
    assert other.progress.steps == whole.progress.steps


def test_the_result_turns_and_mirrors_with_the_scene():
    def bent(Q):
        model = still(line(12, 60.0) @ Q.T)
        push = Q @ np.array([-0.02, 0.015, 0.03])
        start = clamped(model.end_frame(0, "start"))
        settle(model, {(0, "start"): start, (0, "end"): End(force=lambda t: min(t, 1.0) * push)})
        return model.centreline()

    plain = bent(np.eye(3))
    assert np.abs(plain[-1] - [60.0, 0.0, 0.0]).max() > 5.0
    for Q in (rotation(), np.diag([1.0, 1.0, -1.0])):
        np.testing.assert_allclose(bent(Q), plain @ Q.T, atol=1e-6)


def test_a_following_force_keeps_its_direction_to_the_rod():
    """Beck's column well below flutter stays straight; across it, the reaction is the load along the end."""
    model = still(line(12, 60.0))
    turn = clamped(model.end_frame(0, "start"))
    settle(model, {(0, "start"): turn, (0, "end"): End(following=lambda t: -0.01 * min(t, 1.0))})
    np.testing.assert_allclose(model.centreline()[:, 1:], 0.0, atol=1e-12)
    np.testing.assert_allclose(model.reaction(0, "start"), [0.01, 0.0, 0.0], atol=1e-7)


def test_a_following_force_on_a_rod_that_turns_far_costs_few_iterations():
    """The line search weighs it, and lets steps through: 126 iterations, where 685 are taken without it."""
    model = still(line(20, 60.0))
    turn = turned(model.end_frame(0, "start"), np.array([0.0, 0.0, 1.0]), lambda t: 2.0 * t)
    taken = settle(
        model, {(0, "start"): turn, (0, "end"): End(following=lambda t: -0.5 * min(t, 1.0))}, steps=8, move=RADIUS
    )
    assert taken < 200


def test_a_driven_end_goes_where_it_is_told():
    model = still(line(12, 60.0))
    way = np.array([0.0, 0.0, 1.0])
    frame = model.end_frame(0, "end")
    settle(
        model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): driven(frame, way, lambda t: 0.05 * t)}
    )
    np.testing.assert_allclose(model.x[-1, :3], [60.0, 0.0, 0.05], atol=1e-12)
    deflection = model.reaction(0, "end")[2] * 60.0**3 / (12.0 * model.rods[0].bending)
    assert deflection == pytest.approx(0.05, rel=0.01)


def test_an_end_frame_is_the_curve_s_own_before_the_first_phase_and_the_clamp_s_after():
    phi = np.linspace(0.0, 1.0, 21)
    arc = 50.0 * np.stack([np.sin(phi), 1.0 - np.cos(phi), 0.0 * phi], axis=1)
    model = still(arc)
    first = model.end_frame(0, "end")
    np.testing.assert_allclose(first.tangent, [np.cos(1.0), np.sin(1.0), 0.0], atol=1e-3)
    assert first.tangent @ first.director == pytest.approx(0.0, abs=1e-12)
    settle(model, {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): clamped(first)})
    np.testing.assert_array_equal(model.end_frame(0, "end").tangent, first.tangent)


def test_clamping_a_rod_as_it_lies_does_not_twist_it():
    phi = np.linspace(0.0, 7.0, 71)
    helix = np.stack([20.0 * np.cos(phi), 20.0 * np.sin(phi), 4.0 * phi], axis=1)
    model = still(helix)
    model.begin({(0, side): clamped(model.end_frame(0, side)) for side in ("start", "end")})
    np.testing.assert_allclose(model.twist.torque(model.x), 0.0, atol=1e-9)


def test_frozen_places_let_the_twist_go():
    model = still(line(20, 60.0))
    model.x[:, 3] = RADIUS * np.linspace(0.0, 4.0, 21) ** 2
    frozen = np.zeros((21, 4), dtype=bool)
    frozen[:, :3] = True
    settle(model, {(0, "start"): clamped(model.end_frame(0, "start"))}, frozen=frozen)
    np.testing.assert_allclose(model.twists(), 0.0, atol=1e-9)
    np.testing.assert_allclose(model.centreline(), line(20, 60.0), atol=0.0)


def test_a_step_that_whips_a_node_away_is_taken_again():
    model = RodModel([spec(line(10, 60.0))], drag=1.0)
    push = End(force=lambda t: np.array([0.0, 0.0, 5.0]))
    model.begin({(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): push})
    moves, before, cut = [], model.x[:, :3].copy(), 0
    for step in model.march(StepControl(0.05, 1e-6, 0.05, RADIUS), model.settings(), [0.05]):
        moves.append(np.abs(model.x[:, :3] - before).max())
        before, cut = model.x[:, :3].copy(), cut + step.failed
    assert cut > 0
    assert max(moves) <= 1.5 * RADIUS


def test_wrong_input():
    straight = line(4, 8.0)
    with pytest.raises(InputError, match="at least 2"):
        RodModel([spec(line(1, 8.0))])
    with pytest.raises(InputError, match="cylinders need contact"):
        RodModel([spec(straight)], None, [CylinderSpec(np.zeros(3), np.array([0.0, 1.0, 0.0]), 10.0, 0.2)])
    with pytest.raises(InputError, match=r"\(4, 3\)"):
        RodModel([spec(straight, directors=np.zeros((5, 3)))])
    with pytest.raises(InputError, match="no such end"):
        still(straight).begin({(1, "start"): End()})


def test_settings_scale_with_the_rod():
    thin = RodModel([spec(line(4, 8.0), radius=0.5, bending=1.0)], scheme=Scheme()).settings()
    thick = still(line(4, 8.0)).settings()
    assert thin.largest_move == pytest.approx(thick.largest_move / 6.0)
    assert thin.force_tolerance == pytest.approx(1e-6 * 1.0 / 0.25)


def test_no_penetration_without_contact():
    assert still(line(4, 8.0)).penetration == 0.0
    assert still(line(4, 8.0)).contacts().rod.size == 0
    assert crossing(0.25).penetration == pytest.approx(0.25, abs=0.05)
