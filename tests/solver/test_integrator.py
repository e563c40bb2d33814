from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from specimens import at_rest, cross_sections, make_rod, surfaces

from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.rigid import make_cylinder
from knotfem.contact.tube_friction import TubeFriction
from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction
from knotfem.errors import NotConverged, Stopped
from knotfem.solver.constraints import driven, held
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.state import State, longest_move
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.stepping.integrator import AcceptedStep, Continuation, advance, integrate
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag, Inertia

CONTROLLER = StepController(first=0.1, smallest=1e-3, largest=0.4, move=10.0)
ORIGIN = at_rest(np.zeros((1, 3)))
ONE = Sections.single(np.zeros(1, dtype=int))


class Integration:
    """What the integrator is called with, but for where it sets out; `last` is the last term."""

    def __init__(self, system, controller, newton, sections, output_times) -> None:
        self.system: System = system
        self.last: Any = system.terms[-1]
        self.controller, self.newton, self.sections = controller, newton, sections
        self.output_times = np.array(output_times)

    def __call__(self, start: Continuation | State, interrupt=None) -> Iterator[AcceptedStep]:
        start = Continuation.at(start) if isinstance(start, State) else start
        return integrate(self.system, start, self.controller, self.newton, self.sections, self.output_times, interrupt)


def point(
    spring, push, controller=CONTROLLER, output_times=(1.0,), refuses=lambda step: False, force=3.0
) -> Integration:
    """A point on a spring, pulled by a force that grows with time."""
    terms = [spring(1.0), push(lambda time: np.array([force * time, 0.0, 0.0]), refuses)]
    system = System(terms, Unknowns(1), make_solver("superlu"), Scheme())
    return Integration(system, controller, Newton(largest_move=100.0), ONE, output_times)


def replace_newton(integration: Integration, newton: Newton) -> Integration:
    """The same system with another solver."""
    return Integration(
        integration.system, integration.controller, newton, integration.sections, integration.output_times
    )


def bits(state: State) -> dict[str, bytes]:
    """All arrays of a state, for comparison."""
    arrays = {"x": state.x, "v": state.v, "a": state.a}
    arrays |= {f"{label}.{name}": value for label, part in state.history.items() for name, value in part.items()}
    return {name: value.tobytes() for name, value in arrays.items()}


def test_arrives_exactly_at_every_output_time(spring, push):
    times = (0.25, 0.37, 0.8, 1.0)
    taken = list(point(spring, push, output_times=times)(ORIGIN))
    arrived = [step.state.time for step in taken if step.at_output]
    assert len(arrived) == 4
    np.testing.assert_allclose(arrived, times, rtol=1e-14)
    assert all(step.dt <= CONTROLLER.largest * (1 + 1e-12) for step in taken)
    np.testing.assert_allclose([step.state.x[0, 0] for step in taken], [3.0 * s.state.time for s in taken])


def test_steps_follow_one_another(spring, push):
    taken = list(point(spring, push)(ORIGIN))
    assert taken[0].start is ORIGIN
    for before, after in pairwise(taken):
        assert after.start is before.state
    assert taken[-1].state.time == pytest.approx(1.0, rel=1e-14)


def test_easy_steps_grow_and_are_not_shrunk_by_a_short_last_one(spring, push):
    steps = [step.dt for step in point(spring, push, output_times=(0.24, 10.0))(ORIGIN)]
    np.testing.assert_allclose(steps[:2], [0.1, 0.14])
    assert steps[2] == pytest.approx(0.14 * 1.4)
    assert max(steps) == pytest.approx(0.4)


def moves(steps: Iterator[AcceptedStep]) -> list[float]:
    """Longest move of each step; none of them was rejected before."""
    found = []
    for step in steps:
        assert step.rejected == 0
        found.append(float(np.abs(step.state.x - step.start.x).max()))
    return found


def test_aims_at_a_largest_move(spring, push):
    steps = point(spring, push, StepController(0.1, 1e-3, 1.0, move=0.3), output_times=(3.0,))(ORIGIN)
    np.testing.assert_allclose(moves(steps)[1:-2], 0.3, rtol=1e-6)


def test_step_after_an_output_time_aims_at_the_move_too(spring, push):
    steps = point(spring, push, StepController(0.1, 1e-3, 1.0, move=0.3), output_times=(0.13, 3.0))(ORIGIN)
    assert max(moves(steps)) == pytest.approx(0.3, rel=1e-6)


def test_every_failure_cuts_once_and_is_counted(spring, push):
    """Steps over 0.03 s are refused: 0.1 -> 0.04 -> 0.016 takes two cuts."""
    refusing = point(spring, push, refuses=lambda step: step.dt > 0.03)
    step = next(refusing(ORIGIN))
    assert step.rejected == 2
    assert step.dt == pytest.approx(0.1 * 0.4**2)
    assert refusing.last.begun == pytest.approx([0.1, 0.04, 0.016])
    assert "not finite" in step.failure


def test_rejected_attempts_leave_no_trace(spring, push):
    """A step that sets out from a state after refusals ends as one that was never refused."""
    refusing = point(spring, push, refuses=lambda step: step.dt > 0.03)
    plain = point(spring, push, replace(CONTROLLER, first=0.1 * 0.4 * 0.4))
    first, other = next(refusing(ORIGIN)), next(plain(ORIGIN))
    assert (first.rejected, other.rejected) == (2, 0)
    assert first.dt == other.dt
    history = first.state.history
    assert history["push-1"]["scratch"].tobytes() == other.state.history["push-1"]["scratch"].tobytes()
    np.testing.assert_allclose(first.state.x, other.state.x, atol=1e-5)


def test_the_last_state_survives_a_failure_to_the_bit(spring, push):
    """Steps that end after 0.25 s are refused for good; the state before is as it was, and can be gone on from."""
    refusing = point(spring, push, refuses=lambda step: step.end > 0.25)
    kept = []

    def take() -> None:
        for step in refusing(ORIGIN):
            kept.append((step.after, bits(step.state)))

    with pytest.raises(NotConverged, match="smallest step"):
        take()
    assert len(kept) > 1
    for continuation, before in kept:
        assert bits(continuation.state) == before
    assert kept[-1][0].state.time <= 0.25
    willing = point(spring, push)
    refusing.last.refuses = lambda step: False
    ends = [[bits(step.state) for step in steps(kept[-1][0])] for steps in (refusing, willing)]
    assert ends[0] == ends[1]


def test_strands_that_lie_on_each_other_fail_the_step(spring, push):
    """What compiled loops raise on the way may be no more than a step that is too long."""
    integration = point(spring, push)
    term = integration.last
    plain = term.assemble

    def assemble(x, residual, matrix) -> bool:
        return plain(x, residual, matrix) if term.begun[-1] < 0.03 else bool(1 // 0)

    term.assemble = assemble
    step = next(integration(ORIGIN))
    assert (step.rejected, step.failure) == (2, "strands or nodes lie on each other")


def test_gives_up_at_the_smallest_step(spring, push):
    refusing = point(spring, push, refuses=lambda step: True)
    taken = []
    with pytest.raises(NotConverged, match="no balance at time 0 s"):
        taken.extend(refusing(ORIGIN))
    assert refusing.last.begun[-1] <= CONTROLLER.smallest
    assert not taken


def test_step_that_leaps_is_taken_again_shorter(spring, push):
    leaping = point(spring, push, StepController(0.4, 1e-3, 1.0, move=0.35), output_times=(1.0,))
    first = next(leaping(ORIGIN))
    assert first.rejected == 1
    assert first.state.x[0, 0] == pytest.approx(3.0 * 0.4 * 0.4)
    assert "a node moved by 1.2 mm" in first.failure


def test_one_step_is_the_first_of_many(spring, push):
    integration = point(spring, push)
    first = next(integration(ORIGIN))
    start = Continuation.at(ORIGIN)
    alone = advance(
        integration.system,
        start,
        CONTROLLER,
        integration.newton,
        ONE,
        integration.output_times,
    )
    assert alone is not None
    assert bits(alone.state) == bits(first.state)
    assert alone.after.pace == first.after.pace


def test_nothing_is_left_to_do_at_the_last_output_time(spring, push):
    integration = point(spring, push)
    *_, last = integration(ORIGIN)
    assert list(integration(last.after)) == []


def rubbing() -> tuple[Integration, State, Friction]:
    """A rod dragged over a cylinder with friction: everything that has history variables but pairs."""
    rod = make_rod(16.0, 10, core_stiffness=200.0)
    x = rod.mesh.nodes + np.array([3.02, 0.0, 0.0])
    cylinder = make_cylinder(np.array([-10.0, 0.0, 8.0]), np.array([0.0, 1.0, 0.0]), 10.0)
    contact = ObstacleContact(*surfaces([rod], 1.0), Penalty(11.4, 0.2), cylinder)
    friction = Friction(contact, TubeObstacleFriction(0.1), np.array([0.4]))
    terms = [*rod.terms, Inertia(rod.mass), Drag(rod.mass, 20.0), contact, friction]
    ends = [
        driven(rod.sections[k], x[rod.sections[k]], np.array([-0.1, 0.0, 1.0]), lambda time: 2.0 * time)
        for k in (0, -1)
    ]
    system = System(terms, Unknowns(len(x)), make_solver("auto"), BackwardEuler(), ends)
    controller = StepController(first=0.05, smallest=1e-5, largest=0.4, move=0.5)
    newton = Newton(ForceTolerance(node=1e-7, resultant=1e-5))
    return Integration(system, controller, newton, cross_sections(rod), [0.3, 1.0]), at_rest(x), friction


def crossing() -> tuple[Integration, State, Friction]:
    """A rod dragged across another one with friction: pairs with anchors, and searches on the way."""
    lower = make_rod(16.0, 8)
    upper = make_rod(16.0, 8, first=len(lower.mesh.nodes))
    down = lower.mesh.nodes - [0.0, 0.0, 8.0]
    across = (upper.mesh.nodes - [0.0, 0.0, 8.0])[:, [0, 2, 1]] * [1.0, 1.0, -1.0] + [5.9, 0.0, 0.0]
    x = np.vstack([down, across])
    contact = PairContact(*surfaces([lower, upper], 0.75), Penalty(11.4, 0.2))
    friction = Friction(contact, TubeFriction(0.1), np.full((2, 2), 0.4))
    mass = np.concatenate([lower.mass, upper.mass])
    terms = [*lower.terms, *upper.terms, Inertia(mass), Drag(mass, 20.0), contact, friction]
    ends = [held(nodes, x[nodes]) for nodes in lower.sections[[0, -1]]]
    ends += [
        driven(nodes, x[nodes], np.array([0.0, 0.0, 1.0]), lambda time: 1.5 * time) for nodes in upper.sections[[0, -1]]
    ]
    system = System(terms, Unknowns(len(x)), make_solver("auto"), BackwardEuler(), ends)
    controller = StepController(first=0.05, smallest=1e-5, largest=0.4, move=0.3)
    newton = Newton(ForceTolerance(node=1e-7, resultant=1e-5))
    return Integration(system, controller, newton, cross_sections(lower, upper), [0.3, 1.0]), at_rest(x), friction


CASES = pytest.mark.parametrize("case", [rubbing, crossing])


@CASES
def test_the_same_integration_gives_the_same_bits(case):
    (first, start, _), (second, _, _) = case(), case()
    count = 0
    for a, b in zip(first(start), second(start), strict=True):
        assert bits(a.state) == bits(b.state)
        assert a.solution.iterations == b.solution.iterations
        count += 1
    assert count > 4


@CASES
def test_goes_on_from_a_continuation_in_another_system_to_the_bit(case):
    whole, start, friction = case()
    kept, rest = None, []
    for step in whole(start):
        if kept is not None:
            rest.append(step)
        elif step.at_output:
            assert friction.sliding > 0
            kept = step.after, whole.system.keys
    assert kept is not None
    assert kept[1] is not None
    assert len(rest) > 1
    resumed, _, _ = case()
    resumed.system.restore_pattern(kept[1])
    for a, b in zip(resumed(kept[0]), rest, strict=True):
        assert bits(a.state) == bits(b.state)
        assert (a.dt, a.solution.iterations, a.rejected) == (b.dt, b.solution.iterations, b.rejected)


@CASES
def test_the_same_state_can_be_continued_twice_to_the_same_bits(case):
    """In one system, whose terms stand at the end of the first continuation when the second sets out."""
    integration, start, _ = case()
    *_, at = (step for step in integration(start) if step.state.time < 0.31)
    keys, before = integration.system.keys, bits(at.state)
    assert keys is not None
    ends = []
    for _ in range(2):
        integration.system.restore_pattern(keys)
        *_, last = integration(at.after)
        ends.append(bits(last.state))
        assert bits(at.state) == before
    assert ends[0] == ends[1]


@CASES
def test_rejected_steps_leave_the_arrays_of_the_given_state_untouched(case):
    """Every array is read only and still the steps are taken, refused and taken again."""
    integration, start, _ = case()
    hopeless = replace(integration.newton, tolerance=ForceTolerance(1e-30, 1e-30), max_iterations=2)
    *_, at = (step for step in integration(start) if step.state.time < 0.31)
    arrays = [at.state.x, at.state.v, at.state.a, at.after.increment]
    arrays += [value for part in at.state.history.values() for value in part.values()]
    before = bits(at.state)
    for array in arrays:
        array.flags.writeable = False
    with pytest.raises(NotConverged):
        next(replace_newton(integration, hopeless)(at.after))
    assert bits(at.state) == before
    *_, last = integration(at.after)
    assert last.state.time == pytest.approx(1.0)
    assert bits(at.state) == before


def test_a_step_that_is_interrupted_has_not_begun():
    whole, start, _ = rubbing()
    ends = [step.state for step in whole(start)]
    halted, _, _ = rubbing()
    taken, seen = [], []

    def interrupt() -> None:
        """In the third iteration of the fourth step."""
        seen.append(len(taken))
        if seen.count(3) == 3:
            raise Stopped("asked to stop")

    def take() -> None:
        for step in halted(start, interrupt):
            taken.append(step)

    with pytest.raises(Stopped):
        take()
    assert len(taken) == 3 < len(ends)
    resumed, _, _ = rubbing()
    assert halted.system.keys is not None
    resumed.system.restore_pattern(halted.system.keys)
    rest = [step.state for step in resumed(taken[-1].after)]
    assert len(rest) == len(ends) - 3
    assert bits(rest[-1]) == bits(ends[-1])


def test_longest_move_does_not_depend_on_the_axes() -> None:
    turn = np.array([[0.36, 0.48, -0.80], [-0.80, 0.60, 0.0], [0.48, 0.64, 0.60]])
    dx = np.array([[3.0, 4.0, 0.0], [0.0, 4.5, 0.0]])
    assert longest_move(dx) == pytest.approx(5.0)
    assert longest_move(dx @ turn.T) == pytest.approx(5.0)
    assert longest_move(np.array([[0.3, 0.4, 0.0, -2.0]])) == 2.0
