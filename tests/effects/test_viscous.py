"""Viscous drag: tangent, indifference to a turn, coefficients of a straight rod, a rod that falls."""

import numpy as np
import pytest
from derivatives import directional_error, residual, rotation, tangent
from specimens import make_rod

from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.stepping.integrator import March, Progress, StepControl
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.sparse.linear import make_solver
from knotfem.terms.gravity import Gravity
from knotfem.terms.inertia import Inertia
from knotfem.terms.registry import module_of
from knotfem.terms.viscous import Settings, ViscousDrag, absent, make

NORMAL, TANGENTIAL = 4e-6, 1.7e-6
SCHEMES = [Scheme(), BackwardEuler(), hht(-0.1), generalised_alpha(0.6)]


class Strand:
    """A straight rod as the registry hands it to an effect."""

    def __init__(self, length: float = 24.0, slices: int = 6) -> None:
        self.rod = make_rod(length, slices, section=4)
        self.mesh, self.section_nodes, self.axis_nodes = self.rod.mesh, self.rod.sections, self.rod.axis


def bent(strand: Strand) -> np.ndarray:
    """Positions along a wave, so that no two edges point the same way."""
    x = strand.mesh.nodes.copy()
    x[:, 0] += 2.0 * np.sin(0.3 * x[:, 2])
    x[:, 1] += 1.5 * np.cos(0.2 * x[:, 2])
    return x


def started(effect: ViscousDrag, x: np.ndarray, dt: float = 0.2) -> np.ndarray:
    """Begin a step from x; positions that it may end at."""
    rng = np.random.default_rng(1)
    effect.begin(StepStart(Motion(x, rng.normal(size=x.shape), rng.normal(size=x.shape)), dt))
    return x + 0.1 * rng.normal(size=x.shape)


def drag_of(strand: Strand, scheme: Scheme, normal: float = NORMAL, tangential: float = TANGENTIAL) -> ViscousDrag:
    drag = make(Settings(normal, tangential), [strand])
    drag.integrate(scheme)
    return drag


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: type(scheme).__name__)
def test_tangent_is_the_symmetric_derivative_of_the_residual(scheme):
    strand = Strand()
    drag = drag_of(strand, scheme)
    x = started(drag, bent(strand))
    assert directional_error([drag], x) < 1e-8
    full = tangent([drag], x)
    assert drag.symmetric
    np.testing.assert_allclose(full, full.T, atol=1e-18)
    np.testing.assert_allclose(tangent([drag], x, upper=True), full, atol=1e-18)


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: type(scheme).__name__)
def test_merit_gradient_is_the_residual(scheme):
    strand = Strand()
    drag = drag_of(strand, scheme)
    x = started(drag, bent(strand))
    d = np.random.default_rng(5).standard_normal(x.shape)
    slope = (drag.merit(x + 1e-4 * d) - drag.merit(x - 1e-4 * d)) / 2e-4
    assert slope == pytest.approx(float(np.sum(residual([drag], x) * d)), rel=1e-7)


def test_force_turns_with_the_rod_and_its_motion():
    strand, Q = Strand(), rotation()
    x = bent(strand)
    v = np.random.default_rng(2).normal(size=x.shape)
    forces = []
    for turn in (np.eye(3), Q):
        drag = drag_of(strand, Scheme())
        drag.begin(StepStart(Motion.at_rest(x @ turn.T), 0.1))
        forces.append(residual([drag], (x + 0.1 * v) @ turn.T))
    np.testing.assert_allclose(forces[1], forces[0] @ Q.T, atol=1e-18)


@pytest.mark.parametrize("slices", [3, 8])
def test_straight_rod_meets_each_coefficient_times_its_length(slices):
    strand = Strand(24.0, slices)
    x = strand.mesh.nodes
    drag = drag_of(strand, Scheme())
    drag.begin(StepStart(Motion.at_rest(x), 0.1))
    moved = x + 0.1 * np.array([2.0, -1.0, 3.0])
    force = residual([drag], moved).sum(axis=0)
    np.testing.assert_allclose(force, 24.0 * np.array([2.0 * NORMAL, -NORMAL, 3.0 * TANGENTIAL]), rtol=1e-9)


def test_equal_coefficients_do_not_know_the_direction():
    strand = Strand()
    x = bent(strand)
    drag = drag_of(strand, Scheme(), 3e-6, 3e-6)
    drag.begin(StepStart(Motion.at_rest(x), 0.1))
    force = residual([drag], x + np.array([0.1, 0.0, 0.0])).sum(axis=0)
    np.testing.assert_allclose(force, [24.0 * 3e-6, 0.0, 0.0], atol=1e-15)


def fallen(angle: float, seconds: float, dt: float) -> np.ndarray:
    """Velocity of the centre of a rod that falls freely from rest, inclined by an angle to the vertical."""
    strand = Strand()
    rod = strand.rod
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    x = rod.mesh.nodes @ turn.T
    scheme = BackwardEuler()
    effects = [rod.bulk, Inertia(rod.mass), Gravity(rod.mass, np.array([0.0, 0.0, -9810.0]))]
    effects.append(drag_of(strand, scheme))
    system = System(effects, len(x), make_solver("auto"), scheme)
    settings = NewtonSettings(force_tolerance=1e-9, resultant_tolerance=1e-8, largest_move=1e3, endgame_move=1e3)
    control = StepControl(first=dt, smallest=dt, largest=dt, move=1e6)
    steps = March(system, Progress.at(Motion.at_rest(x)), control, settings, rod.section_index, np.array([seconds]))
    for _ in steps:
        pass
    v = steps.progress.motion.v
    return (rod.mass @ v) / rod.mass.sum()


@pytest.mark.parametrize("angle", [0.0, 0.5 * np.pi, 0.7])
def test_falling_rod_reaches_its_terminal_velocity(angle):
    """Weight per length is resisted along and across by c_t v_t and c_n v_n; an inclined rod drifts sideways."""
    rod = make_rod(24.0, 6, section=4)
    weight = rod.mass.sum() * 9810.0 / 24.0
    along = np.array([np.sin(angle), 0.0, np.cos(angle)])
    across = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    expected = -weight * (np.cos(angle) / TANGENTIAL * along - np.sin(angle) / NORMAL * across)
    found = fallen(angle, 1.0, 0.02)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-3 * np.linalg.norm(expected))


def test_way_to_the_terminal_velocity_is_exponential():
    rod = make_rod(24.0, 6, section=4)
    weight, per_length = rod.mass.sum() * 9810.0 / 24.0, rod.mass.sum() / 24.0
    time, steps = 0.02, 200
    expected = -weight / TANGENTIAL * (1.0 - (1.0 + TANGENTIAL / per_length * time / steps) ** -steps)
    assert fallen(0.0, time, time / steps)[2] == pytest.approx(expected, rel=1e-4)
    assert expected == pytest.approx(-weight / TANGENTIAL * (1.0 - np.exp(-TANGENTIAL / per_length * time)), rel=3e-3)


def test_settings_say_when_they_call_for_nothing():
    assert absent(Settings(0.0, 0.0)) == "both coefficients are 0"
    assert absent(Settings(0.0, 1e-6)) == ""
    assert module_of("viscous_drag").make is make
