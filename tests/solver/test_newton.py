import numpy as np
import pytest
from specimens import make_rod

from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.nonlinear import newton
from knotfem.solver.nonlinear.newton import NewtonSettings, StepFailed, out_of_balance, solve
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.sparse.linear import make_solver

ONE = np.zeros(1, dtype=int)


def pulled(spring, push, force, cubic=1.0, stiffness=1.0):
    system = System(
        [spring(stiffness, cubic), push(lambda time: np.array([force, 0.0, 0.0]))], 1, make_solver("superlu"), Scheme()
    )
    start = StepStart(Motion.at_rest(np.zeros((1, 3))), 1.0)
    system.begin(start)
    return system, start


def test_finds_the_root(spring, push):
    system, start = pulled(spring, push, 10.0)
    x, took = solve(system, start.motion.x, start, NewtonSettings(force_tolerance=1e-12), ONE)
    np.testing.assert_allclose(x, [[2.0, 0.0, 0.0]], atol=1e-12)
    assert took.residual < 1e-12


def test_an_element_inside_out_is_no_balance():
    """Prescribed nodes push a layer through its neighbour; forces balance, and the state is refused."""
    rod = make_rod(4.0, 2)
    X = rod.mesh.nodes
    through = X[rod.sections[1]] + [0.0, 0.0, 3.0]
    ends = [
        held(rod.sections[k], place) for k, place in ((0, X[rod.sections[0]]), (1, through), (2, X[rod.sections[2]]))
    ]
    system = System(rod.effects, len(X), make_solver("auto"), Scheme(), ends)
    start = StepStart(Motion.at_rest(X), 1.0)
    system.begin(start)
    with pytest.raises(StepFailed, match="an element is inverted"):
        solve(system, X, start, NewtonSettings(), rod.section_index)


def test_converges_quadratically():
    """A bent and sheared rod: pressures and core forces follow as unknowns of their own."""
    rod = make_rod(12.0, 8, poisson=0.49, core_stiffness=40.0)
    X = rod.mesh.nodes
    turn = np.array([[0.9, 0.0, -0.4359], [0.0, 1.0, 0.0], [0.4359, 0.0, 0.9]])
    far = (X[rod.sections[-1]] - [0.0, 0.0, 12.0]) @ turn + [-3.0, 0.5, 11.5]
    ends = [held(rod.sections[0], X[rod.sections[0]]), held(rod.sections[-1], far)]
    system = System(rod.effects, len(X), make_solver("auto"), Scheme(), ends)
    system.begin(StepStart(Motion.at_rest(X), 1.0))
    x, errors = X.copy(), []
    for _ in range(9):
        residual, matrix = system.tangent(x)
        gap = np.where(system.fixed, system.targets(1.0) - x, 0.0)
        errors.append(float(np.abs(np.where(system.fixed, 0.0, residual)).max()))
        rhs = -residual - matrix.multiply(gap.ravel()).reshape(-1, 3)
        du = system.solve(matrix, 0.0, rhs) + gap
        system.increment(du)
        x = x + du
        system.advance(1.0)
    last = next(k for k, error in enumerate(errors) if k and error < 1e-9)
    order = np.log(errors[last] / errors[last - 1]) / np.log(errors[last - 1] / errors[last - 2])
    assert last < 9
    assert order > 1.8


def test_last_iteration_takes_the_factorisation_before_it_again(spring, push):
    settings = NewtonSettings(force_tolerance=1e-5, resultant_tolerance=1e-4)
    system, start = pulled(spring, push, 1.0, cubic=1e-4)
    x, took = solve(system, start.motion.x, start, settings, ONE)
    assert x[0, 0] == pytest.approx(0.9999, abs=1e-6)
    assert took.residual < 1e-5
    assert system.factorisations == took.count - 1
    far, start = pulled(spring, push, 1.0, cubic=1e-2)
    _, took = solve(far, start.motion.x, start, settings, ONE)
    assert far.factorisations == took.count > 1


def test_largest_residual_and_running_sum():
    residual = np.zeros((6, 3))
    residual[:, 0] = 1e-3
    residual[5] = [7.0, 0.0, 0.0]
    fixed = np.zeros((6, 3), dtype=bool)
    fixed[5] = True
    largest, running = out_of_balance(residual, fixed, np.array([0, 0, 1, 1, 2, 2]))
    assert largest == pytest.approx(1e-3)
    assert running == pytest.approx(5e-3)


def test_coherent_residuals_do_not_pass(spring, push):
    """Each unknown is within its tolerance, their sum is not."""
    residual = np.full((100, 3), 0.9e-5)
    largest, running = out_of_balance(residual, np.zeros((100, 3), dtype=bool), np.repeat(np.arange(10), 10))
    settings = NewtonSettings()
    assert largest < settings.force_tolerance
    assert running > settings.resultant_tolerance


def test_prescribed_nodes_arrive_exactly(spring, push):
    goal = np.array([[0.3, -0.2, 0.1]])
    system = System(
        [spring(1.0, 2.0)], 2, make_solver("superlu"), Scheme(), [Prescribed(np.array([1]), lambda time: goal * time)]
    )
    start = StepStart(Motion.at_rest(np.full((2, 3), 0.5)), 3.0)
    system.begin(start)
    x, _ = solve(system, start.motion.x, start, NewtonSettings(force_tolerance=1e-11), np.zeros(2, dtype=int))
    np.testing.assert_array_equal(x[1], 3.0 * goal[0])
    np.testing.assert_allclose(x[0], 0.0, atol=1e-6)


def test_too_few_iterations_fail(spring, push):
    system, start = pulled(spring, push, 10.0)
    with pytest.raises(StepFailed, match="after 2 iterations"):
        solve(system, start.motion.x, start, NewtonSettings(max_iterations=2), ONE)


def test_a_residual_that_is_not_finite_fails(spring, push):
    system, start = pulled(spring, push, np.nan)
    with pytest.raises(StepFailed, match="not finite"):
        solve(system, start.motion.x, start, NewtonSettings(), ONE)


def test_no_iteration_moves_further_than_allowed(spring, push, monkeypatch):
    system, start = pulled(spring, push, 1.0, cubic=0.0, stiffness=0.01)
    moves = []
    fraction = newton._fraction

    def spy(system, x, du, *rest):
        moves.append(float(np.abs(du).max()))
        return fraction(system, x, du, *rest)

    monkeypatch.setattr(newton, "_fraction", spy)
    settings = NewtonSettings(force_tolerance=1e-9, largest_move=1.5, max_iterations=500)
    x, _ = solve(system, start.motion.x, start, settings, ONE)
    assert x[0, 0] == pytest.approx(100.0, abs=1e-5)
    assert max(moves) <= 1.5 * (1.0 + 1e-12)
    assert len(moves) > 60


def test_a_negative_stiffness_is_climbed_out_of(spring, push):
    """From the top of a double well the shift and the line search lead down."""
    system, start = pulled(spring, push, 0.0, cubic=1.0, stiffness=-1.0)
    x0 = np.array([[0.05, 0.0, 0.0]])
    x, took = solve(system, x0, start, NewtonSettings(force_tolerance=1e-10, max_iterations=60), ONE, shift=2.0)
    assert np.linalg.norm(x) == pytest.approx(1.0, abs=1e-9)
    assert took.count < 60
