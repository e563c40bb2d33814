"""Quasi-static steps on terms whose equilibria are known by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from specimens import at_rest

from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.state import State
from knotfem.solver.stepping.continuation import Continuation
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep, integrate
from knotfem.solver.stepping.pace import Outcome, Pace, Trial
from knotfem.solver.stepping.quasi_static import DRAG_RATE, QuasiStatic
from knotfem.solver.system import System
from knotfem.solver.term import Conditions
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Inertia, NumericalDrag

ONE = Sections.single(np.zeros(1, dtype=int))
LOADS = StepController(first=0.01, smallest=1e-7, largest=1.0, move=0.2)
STIFFNESS, CUBIC = -1.0, 1.0
FOLD = 2.0 / 3.0 * np.sqrt(1.0 / 3.0)
"""Force at which a spring with force -x + x^3 leaves the branch of negative x."""
AFTER = 2.0 / np.sqrt(3.0)
"""Where it lands: the other root of x^3 - x = `FOLD`."""


def pacing(mass: float = 1e-6, tolerance: float = 0.002, **changed) -> QuasiStatic:
    """Of a point."""
    return replace(QuasiStatic(LOADS, mass, 1.0, tolerance, 1e-6, LOADS.move, 0.02), **changed)


def snapping(spring, push, rule: QuasiStatic, mass: float = 1e-6, end: float = 1.0):
    """A point on a bistable spring, pushed through by a force that grows by 1 N a second."""
    springs = spring(STIFFNESS, CUBIC)
    force = push(lambda time: np.array([time, 0.0, 0.0]))
    fixed = np.array([[False, True, True]])
    system = System(
        [springs, NumericalDrag(np.array([mass]), DRAG_RATE), force],
        Unknowns(1, fixed=fixed),
        make_solver("superlu"),
        Scheme(),
        conditions=Conditions(real=False),
    )
    newton = Newton(ForceTolerance(1e-9, 1e-9), largest_move=0.5)
    times = np.linspace(0.0, end, 11)[1:]

    def steps(start: Continuation | State):
        at = Continuation.at(start) if isinstance(start, State) else start
        return integrate(system, at, rule, newton, ONE, times)

    return steps


START = at_rest(np.array([[-1.0, 0.0, 0.0]]))


def jump(steps: list[AcceptedStep]) -> tuple[float, float, float, float]:
    """Forces before and at the jump, and the places before and after."""
    still = [step for step in steps if step.advance == 0.0 and step.start.x[0, 0] < 0.0]
    here = [step for step in steps if step.state.time == still[-1].start.time]
    return here[0].start.time, here[0].state.time, here[0].start.x[0, 0], here[-1].state.x[0, 0]


def test_a_stable_branch_is_followed_in_equilibrium(spring, push):
    taken = list(snapping(spring, push, pacing(), end=0.3)(START))
    for step in taken:
        if step.settled:
            x = step.state.x[0, 0]
            assert abs(x**3 - x - step.state.time) <= max(0.002 * step.state.time, 1e-6) * (1 + 1e-6)
    assert taken[-1].state.time == pytest.approx(0.3)


def test_a_jump_happens_where_the_branch_ends_and_lands_on_the_other_one(spring, push):
    last, at, before, after = jump(list(snapping(spring, push, pacing())(START)))
    assert last <= FOLD * 1.002
    assert FOLD <= at <= FOLD * 1.01
    assert before == pytest.approx(-np.sqrt(1.0 / 3.0), abs=0.06)
    assert after == pytest.approx(AFTER, abs=5e-3)


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e3])
def test_the_scale_of_the_drag_cancels(spring, push, factor):
    """The mass on which drag acts enters the time over which rates are taken, and nothing else."""
    plain = [s.state.x[0, 0] for s in snapping(spring, push, pacing(1e-6), 1e-6)(START)]
    other = [s.state.x[0, 0] for s in snapping(spring, push, pacing(1e-6 * factor), 1e-6 * factor)(START)]
    np.testing.assert_allclose(other, plain, rtol=1e-7)


@pytest.mark.parametrize("tolerance", [2e-4, 2e-3, 2e-2])
def test_the_jump_depends_little_on_the_tolerance(spring, push, tolerance):
    last, at, _, after = jump(list(snapping(spring, push, pacing(tolerance=tolerance))(START)))
    assert last <= FOLD * (1.0 + tolerance)
    assert FOLD * (1.0 - tolerance) <= at <= FOLD * 1.03
    assert after == pytest.approx(AFTER, abs=0.02)


def test_outputs_wait_for_equilibrium(spring, push):
    """Output times are met exactly, and what drag carries then is within tolerance."""
    taken = list(snapping(spring, push, pacing())(START))
    outputs = [step for step in taken if step.at_output]
    np.testing.assert_allclose([step.state.time for step in outputs], np.linspace(0.1, 1.0, 10), rtol=1e-12)
    for step in outputs:
        x = step.state.x[0, 0]
        assert step.settled
        assert abs(x**3 - x - step.state.time) <= 0.002 * step.state.time * (1 + 1e-6)


def test_a_body_out_of_balance_settles_before_loads_advance(spring, push):
    first = next(iter(snapping(spring, push, pacing())(at_rest(np.array([[-0.2, 0.0, 0.0]])))))
    assert (first.advance, first.settled) == (0.0, False)
    settled = [s for s in snapping(spring, push, pacing())(at_rest(np.array([[-0.2, 0.0, 0.0]]))) if s.settled]
    assert settled[0].state.time == 0.0
    assert settled[0].state.x[0, 0] == pytest.approx(-1.0, abs=1e-5)


def test_states_have_no_velocity(spring, push):
    """The time of rates is not the time of loads: a step in real time that follows sets out at rest."""
    for step in snapping(spring, push, pacing())(START):
        assert not step.state.v.any()


def test_inertia_is_left_out(spring):
    terms = [spring(1.0), Inertia(np.ones(1))]
    assert len(System(terms, Unknowns(1), make_solver("superlu"), Scheme()).terms) == 1
    assert len(System(terms, Unknowns(1), make_solver("superlu"), BackwardEuler()).terms) == 2


def test_goes_on_in_the_middle_of_a_jump_to_the_bit(spring, push):
    whole = list(snapping(spring, push, pacing())(START))
    middle = next(i for i, step in enumerate(whole) if step.state.time > 0.1 and not step.settled) + 2
    assert whole[middle].advance == 0.0
    rest = list(snapping(spring, push, pacing())(whole[middle].after))
    assert len(rest) == len(whole) - middle - 1
    for a, b in zip(rest, whole[middle + 1 :], strict=True):
        assert a.state.x.tobytes() == b.state.x.tobytes()
        assert (a.advance, a.dt, a.settled, a.at_output) == (b.advance, b.dt, b.settled, b.at_output)


def test_a_failure_while_loads_stand_still_adds_drag():
    rule = pacing()
    pace = Pace(0.01, settling=True, dt=1e-3)
    found = rule.after_failure(pace, Trial(0.0, False, 1e-3))
    assert found is not None
    assert (found.dt, found.advance) == (pytest.approx(3e-4), 0.01)
    assert rule.after_failure(replace(pace, dt=rule.first_dt * 1e-8), Trial(0.0, False, rule.first_dt * 1e-8)) is None


@pytest.mark.parametrize(
    ("moved", "slip", "factor"), [(0.4, 0.0, 0.5), (0.1, 0.0, 2.0), (0.1, 0.04, 0.5), (0.01, 0.001, 2.5)]
)
def test_settling_aims_at_a_move_and_at_a_slip(moved, slip, factor):
    pace, trial = Pace(0.01, settling=True, dt=1e-3), Trial(0.0, False, 1e-3)
    found = pacing().after_success(pace, trial, Outcome(4, moved, 0, 1.0, 1.0, slip))
    assert found.dt == pytest.approx(factor * trial.dt)


def test_a_failure_while_loads_advance_adds_drag_faster_than_it_cuts_the_advance():
    found = pacing().after_failure(Pace(0.01, dt=1e-3), Trial(0.01, False, 1e-3))
    assert found is not None
    assert (found.advance, found.slowness) == (pytest.approx(0.004), pytest.approx(0.1))


@settings(deadline=None)
@given(
    st.booleans(), st.booleans(), st.integers(1, 40), st.floats(0.0, 10.0), st.integers(0, 5), st.floats(0.0, 1.0),
    st.floats(0.0, 100.0),
)  # fmt: skip
def test_loads_advance_only_from_equilibrium(settling, at_output, iterations, moved, rejected, carried, load):
    rule = pacing()
    pace = Pace(0.01, settling=settling, dt=1e-3, due=settling and at_output)
    trial = Trial(0.0, False, 1e-3) if settling else Trial(0.01, at_output, 1e-3)
    found = rule.after_success(pace, trial, Outcome(iterations, moved, rejected, carried, load))
    balanced = carried <= rule.allowance(load)
    assert found.settling is not balanced
    assert found.dt > 0.0
    assert found.due is (not balanced and at_output)
    assert 0.0 < found.slowness <= 1.0
    assert LOADS.smallest <= found.advance <= LOADS.largest
