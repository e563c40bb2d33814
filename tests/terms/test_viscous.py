"""Viscous drag: tangent, indifference to a turn, coefficients of a straight rod, a rod that falls."""

import numpy as np
import pytest
from derivatives import directional_error, residual, rotation, tangent
from specimens import Rod, accepted_steps, at_rest, cross_sections, final_state, make_rod

import knotfem as kf
from knotfem.models.effects import VISCOUS_DRAG
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.state import Motion
from knotfem.solver.system import System
from knotfem.solver.term import TimeStep
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.gravity import Gravity
from knotfem.terms.inertia import Inertia
from knotfem.terms.viscous import ViscousDrag

NORMAL, TANGENTIAL = 4e-6, 1.7e-6
SCHEMES = [Scheme(), BackwardEuler(), hht(-0.1), generalised_alpha(0.6)]


def strand(length: float = 24.0, slices: int = 6) -> Rod:
    """A straight rod."""
    return make_rod(length, slices, section=4)


def bent(rod: Rod) -> np.ndarray:
    """Positions along a wave, so that no two edges point the same way."""
    x = rod.mesh.nodes.copy()
    x[:, 0] += 2.0 * np.sin(0.3 * x[:, 2])
    x[:, 1] += 1.5 * np.cos(0.2 * x[:, 2])
    return x


def drag_of(rod: Rod, normal: float = NORMAL, tangential: float = TANGENTIAL) -> ViscousDrag:
    return ViscousDrag(rod.edges, np.full(len(rod.edges), rod.mesh.element_length), normal, tangential)


def started(drag: ViscousDrag, x: np.ndarray, scheme: Scheme, dt: float = 0.2) -> np.ndarray:
    """Begin a step from x; positions that it may end at."""
    rng = np.random.default_rng(1)
    drag.begin(TimeStep(Motion(x, rng.normal(size=x.shape), rng.normal(size=x.shape)), dt, scheme))
    return x + 0.1 * rng.normal(size=x.shape)


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: type(scheme).__name__)
def test_tangent_is_the_symmetric_derivative_of_the_residual(scheme):
    rod = strand()
    drag = drag_of(rod)
    x = started(drag, bent(rod), scheme)
    assert directional_error([drag], x) < 1e-8
    full = tangent([drag], x)
    assert drag.symmetric
    np.testing.assert_allclose(full, full.T, atol=1e-18)
    np.testing.assert_allclose(tangent([drag], x, upper=True), full, atol=1e-18)


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: type(scheme).__name__)
def test_merit_gradient_is_the_residual(scheme):
    rod = strand()
    drag = drag_of(rod)
    x = started(drag, bent(rod), scheme)
    d = np.random.default_rng(5).standard_normal(x.shape)
    slope = (drag.merit(x + 1e-4 * d) - drag.merit(x - 1e-4 * d)) / 2e-4
    assert slope == pytest.approx(float(np.sum(residual([drag], x) * d)), rel=1e-7)


def test_force_turns_with_the_rod_and_its_motion():
    rod, Q = strand(), rotation()
    x = bent(rod)
    v = np.random.default_rng(2).normal(size=x.shape)
    forces = []
    for turn in (np.eye(3), Q):
        drag = drag_of(rod)
        drag.begin(TimeStep(Motion.at_rest(x @ turn.T), 0.1))
        forces.append(residual([drag], (x + 0.1 * v) @ turn.T))
    np.testing.assert_allclose(forces[1], forces[0] @ Q.T, atol=1e-18)


@pytest.mark.parametrize("slices", [3, 8])
def test_straight_rod_meets_each_coefficient_times_its_length(slices):
    rod = strand(24.0, slices)
    x = rod.mesh.nodes
    drag = drag_of(rod)
    drag.begin(TimeStep(Motion.at_rest(x), 0.1))
    moved = x + 0.1 * np.array([2.0, -1.0, 3.0])
    force = residual([drag], moved).sum(axis=0)
    np.testing.assert_allclose(force, 24.0 * np.array([2.0 * NORMAL, -NORMAL, 3.0 * TANGENTIAL]), rtol=1e-9)


def test_equal_coefficients_do_not_know_the_direction():
    rod = strand()
    x = bent(rod)
    drag = drag_of(rod, 3e-6, 3e-6)
    drag.begin(TimeStep(Motion.at_rest(x), 0.1))
    force = residual([drag], x + np.array([0.1, 0.0, 0.0])).sum(axis=0)
    np.testing.assert_allclose(force, [24.0 * 3e-6, 0.0, 0.0], atol=1e-15)


def fallen(angle: float, seconds: float, dt: float) -> np.ndarray:
    """Velocity of the centre of a rod that falls freely from rest, inclined by an angle to the vertical."""
    rod = strand()
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    x = rod.mesh.nodes @ turn.T
    terms = [rod.bulk, Inertia(rod.mass), Gravity(rod.mass, np.array([0.0, 0.0, -9810.0])), drag_of(rod)]
    system = System(terms, Unknowns(len(x)), make_solver("auto"), BackwardEuler())
    newton = Newton(ForceTolerance(node=1e-9, resultant=1e-8), Armijo(whole_below=1e3), largest_move=1e3)
    steps = accepted_steps(
        system, at_rest(x), cross_sections(rod), [seconds], first=dt, largest=dt, move=1e6, newton=newton
    )
    return (rod.mass @ final_state(steps).v) / rod.mass.sum()


@pytest.mark.parametrize("angle", [0.0, 0.5 * np.pi, 0.7])
def test_falling_rod_reaches_its_terminal_velocity(angle):
    """Weight per length is resisted along and across by c_t v_t and c_n v_n; an inclined rod drifts sideways."""
    rod = make_rod(24.0, 6, section=4)
    weight = rod.mass.sum() * 9810.0 / 24.0
    along = np.array([np.sin(angle), 0.0, np.cos(angle)])
    across = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    expected = -weight * (np.cos(angle) / TANGENTIAL * along - np.sin(angle) / NORMAL * across)
    found = fallen(angle, 1.0, 0.02)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-3 * float(np.linalg.norm(expected)))


def test_way_to_the_terminal_velocity_is_exponential():
    rod = make_rod(24.0, 6, section=4)
    weight, per_length = rod.mass.sum() * 9810.0 / 24.0, rod.mass.sum() / 24.0
    time, steps = 0.02, 200
    expected = -weight / TANGENTIAL * (1.0 - (1.0 + TANGENTIAL / per_length * time / steps) ** -steps)
    assert fallen(0.0, time, time / steps)[2] == pytest.approx(expected, rel=1e-4)
    assert expected == pytest.approx(-weight / TANGENTIAL * (1.0 - np.exp(-TANGENTIAL / per_length * time)), rel=3e-3)


def test_discrete_rods_have_the_same_drag():
    """Four unknowns a node: the force on the places is that of three, the angle has none."""
    rod = strand()
    edges = np.stack([np.arange(6), np.arange(1, 7)], axis=1)
    x = np.zeros((7, 4))
    x[:, :3] = bent(rod)[rod.axis]
    drags = [ViscousDrag(edges, np.full(6, 4.0), NORMAL, TANGENTIAL) for _ in range(2)]
    v = np.random.default_rng(2).normal(size=x.shape)
    forces = []
    for drag, width in zip(drags, (3, 4), strict=True):
        y = np.ascontiguousarray(x[:, :width])
        drag.begin(TimeStep(Motion.at_rest(y), 0.1))
        moved = y + 0.1 * v[:, :width]
        forces.append(residual([drag], moved))
        assert directional_error([drag], moved) < 1e-8
    np.testing.assert_array_equal(forces[1][:, :3], forces[0])
    assert not forces[1][:, 3].any()


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("{normal='0 Pa s', tangential='0 Pa s'}", "both coefficients are 0"),
        ("{normal='0 Pa s', tangential='1 Pa s'}", ""),
        ("none", "not in the scene"),
    ],
)
def test_a_scene_says_why_it_does_without(value, reason):
    overrides = [f"effects.viscous_drag={value}", "steps.0.rate=real"]
    assert VISCOUS_DRAG.absent(kf.load_scene("cantilever", overrides)) == reason
