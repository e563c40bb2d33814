import copy
from itertools import pairwise

import numpy as np
import pytest
from specimens import make_rod, surfaces

from knotfem.contact.penalty import Penalty
from knotfem.contact.tube_cylinder import Cylinder, CylinderFriction
from knotfem.errors import NotConverged, Stopped
from knotfem.solver.constraints import driven
from knotfem.solver.nonlinear.newton import NewtonSettings
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.stepping.integrator import March, Progress, StepControl
from knotfem.solver.system import System
from knotfem.solver.term import Motion, longest_move
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag, Inertia

CONTROL = StepControl(first=0.1, smallest=1e-3, largest=0.4, move=10.0)
ORIGIN = np.zeros((1, 3))
ONE = np.zeros(1, dtype=int)


def point(spring, push, control=CONTROL, stops=(1.0,), refuses=lambda start: False, force=3.0) -> March:
    """A point on a spring, pulled by a force that grows with time."""
    effects = [spring(1.0), push(lambda time: np.array([force * time, 0.0, 0.0]), refuses)]
    system = System(effects, 1, make_solver("superlu"), Scheme())
    settings = NewtonSettings(largest_move=100.0)
    return March(system, Progress.at(Motion.at_rest(ORIGIN)), control, settings, ONE, np.array(stops))


def test_arrives_exactly_at_every_stop(spring, push):
    stops = (0.25, 0.37, 0.8, 1.0)
    taken = list(point(spring, push, stops=stops))
    arrived = [step.motion.time for step in taken if step.arrived]
    assert len(arrived) == 4
    np.testing.assert_allclose(arrived, stops, rtol=1e-14)
    assert all(step.start.dt <= CONTROL.largest * (1 + 1e-12) for step in taken)
    np.testing.assert_allclose([step.motion.x[0, 0] for step in taken], [3.0 * s.motion.time for s in taken])


def test_steps_follow_one_another(spring, push):
    taken = list(point(spring, push))
    for before, after in pairwise(taken):
        assert after.start.motion is before.motion
    assert taken[-1].motion.time == pytest.approx(1.0, rel=1e-14)


def test_easy_steps_grow_and_are_not_shrunk_by_a_short_last_one(spring, push):
    march = point(spring, push, stops=(0.24, 10.0))
    steps = [step.start.dt for step in march]
    np.testing.assert_allclose(steps[:2], [0.1, 0.14])
    assert steps[2] == pytest.approx(0.14 * 1.4)
    assert max(steps) == pytest.approx(0.4)


def test_aims_at_a_largest_move(spring, push):
    march = point(spring, push, StepControl(0.1, 1e-3, 1.0, move=0.3), stops=(3.0,))
    moves = [float(np.abs(step.motion.x - step.start.motion.x).max()) for step in march]
    np.testing.assert_allclose(moves[1:-2], 0.3, rtol=1e-6)


def test_step_after_a_stop_aims_at_the_move_too(spring, push):
    march = point(spring, push, StepControl(0.1, 1e-3, 1.0, move=0.3), stops=(0.13, 3.0))
    moves = [float(np.abs(step.motion.x - step.start.motion.x).max()) for step in march]
    assert march.progress.cutbacks == 0
    assert max(moves) == pytest.approx(0.3, rel=1e-6)


def test_every_failure_cuts_once_and_is_counted(spring, push):
    """Steps over 0.03 s are refused: 0.1 -> 0.04 -> 0.016 takes two cuts."""
    march = point(spring, push, refuses=lambda start: start.dt > 0.03)
    step = next(iter(march))
    assert (step.failed, march.progress.cutbacks) == (2, 2)
    assert step.start.dt == pytest.approx(0.1 * 0.4**2)
    assert march.system.effects[1].begun == pytest.approx([0.1, 0.04, 0.016])
    assert "not finite" in march.last_failure


def test_a_failed_step_is_undone_to_the_bit(spring, push):
    march = point(spring, push, refuses=lambda start: start.end > 0.25)
    kept = []

    def walk() -> None:
        for step in march:
            kept.append((copy.deepcopy(march.system.history()), step.motion.x.tobytes()))

    with pytest.raises(NotConverged, match="smallest step"):
        walk()
    before, motion = kept[-1]
    after = march.system.history()
    for name in ("spring-1", "push-1"):
        for key, value in before[name].items():
            assert after[name][key].tobytes() == value.tobytes()
    assert march.progress.motion.x.tobytes() == motion
    assert march.progress.motion.time <= 0.25


def test_strands_that_lie_on_each_other_fail_the_step(spring, push):
    """What compiled loops raise on the way may be no more than a step that is too long."""
    march = point(spring, push)
    effect = march.system.effects[1]
    plain = effect.assemble

    def assemble(x, residual, matrix) -> bool:
        return plain(x, residual, matrix) if effect.begun[-1] < 0.03 else bool(1 // 0)

    effect.assemble = assemble
    step = next(iter(march))
    assert (step.failed, march.last_failure) == (2, "strands or nodes lie on each other")


def test_gives_up_at_the_smallest_step(spring, push):
    march = point(spring, push, refuses=lambda start: True)
    with pytest.raises(NotConverged, match="no balance at time 0 s"):
        list(march)
    assert march.system.effects[1].begun[-1] <= CONTROL.smallest
    assert march.progress.steps == 0


def rubbing() -> tuple[March, list]:
    """A rod dragged over a cylinder with friction: everything that has a memory but pairs."""
    rod = make_rod(16.0, 10, core_stiffness=200.0)
    x = rod.mesh.nodes + np.array([3.02, 0.0, 0.0])
    scheme = BackwardEuler()
    law = Penalty(11.4, 0.2, 0.1)
    cylinder = Cylinder(surfaces([rod], 1.0)[1], law, np.array([-10.0, 0.0, 8.0]), np.array([0.0, 1.0, 0.0]), 10.0)
    effects = [
        *rod.effects,
        Inertia(rod.mass),
        Drag(rod.mass, 20.0),
        cylinder,
        CylinderFriction(cylinder, np.array([0.4])),
    ]
    ends = [
        driven(rod.sections[k], x[rod.sections[k]], np.array([-0.1, 0.0, 1.0]), lambda time: 2.0 * time)
        for k in (0, -1)
    ]
    system = System(effects, len(x), make_solver("auto"), scheme, ends)
    control = StepControl(first=0.05, smallest=1e-5, largest=0.4, move=0.5)
    settings = NewtonSettings(force_tolerance=1e-7, resultant_tolerance=1e-5)
    stops = np.array([0.3, 1.0])
    return March(system, Progress.at(Motion.at_rest(x)), control, settings, rod.section_index, stops), effects


def test_the_same_march_gives_the_same_bits():
    first, second = rubbing()[0], rubbing()[0]
    for a, b in zip(first, second, strict=True):
        assert a.motion.x.tobytes() == b.motion.x.tobytes()
        assert a.took.count == b.took.count
    assert first.progress.steps > 4


def test_goes_on_from_progress_and_memory_to_the_bit():
    whole, effects = rubbing()
    kept = None
    for step in whole:
        if kept is None and step.arrived:
            assert effects[-1].sliding > 0
            kept = copy.deepcopy(whole.progress), copy.deepcopy(whole.system.history())
    assert kept is not None
    resumed, _ = rubbing()
    resumed.progress = kept[0]
    resumed.system.restore(kept[1])
    for _ in resumed:
        pass
    assert resumed.progress.motion.x.tobytes() == whole.progress.motion.x.tobytes()
    assert resumed.progress.motion.v.tobytes() == whole.progress.motion.v.tobytes()
    for name in ("steps", "iterations", "cutbacks", "dt"):
        assert getattr(resumed.progress, name) == getattr(whole.progress, name)
    ends = resumed.system.history(), whole.system.history()
    for label in ends[1]:
        for key, value in ends[1][label].items():
            assert ends[0][label][key].tobytes() == value.tobytes(), (label, key)


def test_a_step_that_is_interrupted_has_not_begun():
    whole, _ = rubbing()
    for _ in whole:
        pass
    halted, _ = rubbing()
    seen = []

    def interrupt() -> None:
        """In the third iteration of the fourth step."""
        seen.append(halted.progress.steps)
        if seen.count(3) == 3:
            raise Stopped("asked to stop")

    halted.interrupt = interrupt
    with pytest.raises(Stopped):
        list(halted)
    assert halted.progress.steps == 3 < whole.progress.steps
    resumed, _ = rubbing()
    resumed.progress = copy.deepcopy(halted.progress)
    resumed.system.restore(copy.deepcopy(halted.system.history()))
    for _ in resumed:
        pass
    assert resumed.progress.motion.x.tobytes() == whole.progress.motion.x.tobytes()
    assert resumed.progress.iterations == whole.progress.iterations


def test_longest_move_does_not_depend_on_the_axes() -> None:
    turn = np.array([[0.36, 0.48, -0.80], [-0.80, 0.60, 0.0], [0.48, 0.64, 0.60]])
    dx = np.array([[3.0, 4.0, 0.0], [0.0, 4.5, 0.0]])
    assert longest_move(dx) == pytest.approx(5.0)
    assert longest_move(dx @ turn.T) == pytest.approx(5.0)
    assert longest_move(np.array([[0.3, 0.4, 0.0, -2.0]])) == 2.0


def test_step_that_leaps_is_taken_again_shorter(spring, push) -> None:
    march = point(spring, push, StepControl(0.4, 1e-3, 1.0, move=0.35), stops=(1.0,))
    first = next(iter(march))
    assert first.failed == 1
    assert first.motion.x[0, 0] == pytest.approx(3.0 * 0.4 * 0.4)
    assert "a node moved by 1.2 mm" in march.last_failure
