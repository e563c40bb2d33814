import numpy as np
import pytest
from specimens import at_rest, cross_sections, make_rod

from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.nonlinear import newton
from knotfem.solver.nonlinear.newton import Newton, StepFailed
from knotfem.solver.nonlinear.reuse import Chord
from knotfem.solver.nonlinear.tolerance import ForceTolerance, Sections, imbalance
from knotfem.solver.schemes import Scheme
from knotfem.solver.system import System
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver

ONE = Sections.single(np.zeros(1, dtype=int))


def exact(node: float, **changed) -> Newton:
    """With a tolerance on nodes and the usual one on resultants."""
    return Newton(ForceTolerance(node), **changed)


def pulled(spring, push, force, cubic=1.0, stiffness=1.0):
    system = System(
        [spring(stiffness, cubic), push(lambda time: np.array([force, 0.0, 0.0]))],
        Unknowns(1),
        make_solver("superlu"),
        Scheme(),
    )
    return system, system.begin(at_rest(np.zeros((1, 3))), 1.0)


def test_finds_the_root(spring, push):
    system, step = pulled(spring, push, 10.0)
    solution = exact(1e-12).solve(system, step.start.x, step, ONE)
    np.testing.assert_allclose(solution.x, [[2.0, 0.0, 0.0]], atol=1e-12)
    assert solution.imbalance.residual < 1e-12


def test_an_element_inside_out_is_no_balance():
    """Prescribed nodes push a layer through its neighbour; forces balance, and the state is refused."""
    rod = make_rod(4.0, 2)
    X = rod.mesh.nodes
    through = X[rod.sections[1]] + [0.0, 0.0, 3.0]
    ends = [
        held(rod.sections[k], place) for k, place in ((0, X[rod.sections[0]]), (1, through), (2, X[rod.sections[2]]))
    ]
    system = System(rod.terms, Unknowns(len(X)), make_solver("auto"), Scheme(), ends)
    step = system.begin(at_rest(X), 1.0)
    with pytest.raises(StepFailed, match="an element is inverted"):
        Newton().solve(system, X, step, cross_sections(rod))


def test_converges_quadratically():
    """A bent and sheared rod: pressures and core forces follow as unknowns of their own."""
    rod = make_rod(12.0, 8, poisson=0.49, core_stiffness=40.0)
    X = rod.mesh.nodes
    turn = np.array([[0.9, 0.0, -0.4359], [0.0, 1.0, 0.0], [0.4359, 0.0, 0.9]])
    far = (X[rod.sections[-1]] - [0.0, 0.0, 12.0]) @ turn + [-3.0, 0.5, 11.5]
    ends = [held(rod.sections[0], X[rod.sections[0]]), held(rod.sections[-1], far)]
    system = System(rod.terms, Unknowns(len(X)), make_solver("auto"), Scheme(), ends)
    system.begin(at_rest(X), 1.0)
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
    solver = Newton(ForceTolerance(node=1e-5, resultant=1e-4))
    system, step = pulled(spring, push, 1.0, cubic=1e-4)
    solution = solver.solve(system, step.start.x, step, ONE)
    assert solution.x[0, 0] == pytest.approx(0.9999, abs=1e-6)
    assert solution.imbalance.residual < 1e-5
    assert system.factorisations == solution.iterations - 1
    far, step = pulled(spring, push, 1.0, cubic=1e-2)
    solution = solver.solve(far, step.start.x, step, ONE)
    assert far.factorisations == solution.iterations > 1


def test_without_reuse_each_iteration_factorises(spring, push):
    system, step = pulled(spring, push, 1.0, cubic=1e-4)
    solution = Newton(reuse=Chord(np.inf)).solve(system, step.start.x, step, ONE)
    assert system.factorisations == solution.iterations > 1


def test_largest_residual_and_running_sum():
    residual = np.zeros((6, 3))
    residual[:, 0] = 1e-3
    residual[5] = [7.0, 0.0, 0.0]
    fixed = np.zeros((6, 3), dtype=bool)
    fixed[5] = True
    found = imbalance(residual, fixed, Sections.single(np.array([0, 0, 1, 1, 2, 2])))
    assert found.residual == pytest.approx(1e-3)
    assert found.resultant == pytest.approx(5e-3)


def test_resultants_are_summed_rod_by_rod():
    """The sum over one rod does not go on into the next."""
    residual = np.zeros((6, 3))
    residual[:, 0] = [2.0, 1.0, -3.0, 5.0, -1.0, 4.0]
    of_node = np.array([0, 1, 2, 3, 3, 4])
    both, single = Sections(of_node, np.array([0, 3])), Sections.single(of_node)
    np.testing.assert_array_equal(both.running_sums(residual)[:, 0], [2.0, 3.0, 0.0, 4.0, 8.0])
    residual[:3, 0] = [2.0, 1.0, -4.0]
    np.testing.assert_array_equal(both.running_sums(residual)[:, 0], [2.0, 3.0, -1.0, 4.0, 8.0])
    np.testing.assert_array_equal(single.running_sums(residual)[:, 0], [2.0, 3.0, -1.0, 3.0, 7.0])
    assert both.largest_sum(residual) == 8.0
    assert imbalance(residual, np.zeros((6, 3), dtype=bool), both).resultant == 8.0


def test_only_places_are_summed():
    residual = np.zeros((2, 4))
    residual[:, 3] = 7.0
    residual[:, 1] = 0.5
    found = imbalance(residual, np.zeros((2, 4), dtype=bool), Sections.single(np.array([0, 1])))
    assert (found.residual, found.resultant) == (7.0, 1.0)


def test_coherent_residuals_do_not_pass():
    """Each unknown is within its tolerance, their sum is not."""
    residual = np.full((100, 3), 0.9e-5)
    sections = Sections.single(np.repeat(np.arange(10), 10))
    found = imbalance(residual, np.zeros((100, 3), dtype=bool), sections)
    tolerance = ForceTolerance()
    assert found.residual < tolerance.node
    assert found.resultant > tolerance.resultant
    assert tolerance.excess(found) > 1.0


def test_prescribed_nodes_arrive_exactly(spring, push):
    goal = np.array([[0.3, -0.2, 0.1]])
    system = System(
        [spring(1.0, 2.0)],
        Unknowns(2),
        make_solver("superlu"),
        Scheme(),
        [Prescribed(np.array([1]), lambda time: goal * time)],
    )
    step = system.begin(at_rest(np.full((2, 3), 0.5)), 3.0)
    x = exact(1e-11).solve(system, step.start.x, step, Sections.single(np.zeros(2, dtype=int))).x
    np.testing.assert_array_equal(x[1], 3.0 * goal[0])
    np.testing.assert_allclose(x[0], 0.0, atol=1e-6)


def test_too_few_iterations_fail(spring, push):
    system, step = pulled(spring, push, 10.0)
    with pytest.raises(StepFailed, match="after 2 iterations"):
        Newton(max_iterations=2).solve(system, step.start.x, step, ONE)


def test_a_residual_that_is_not_finite_fails(spring, push):
    system, step = pulled(spring, push, np.nan)
    with pytest.raises(StepFailed, match="not finite"):
        Newton().solve(system, step.start.x, step, ONE)


def test_no_iteration_moves_further_than_allowed(spring, push, monkeypatch):
    system, step = pulled(spring, push, 1.0, cubic=0.0, stiffness=0.01)
    moves = []
    fraction = newton._Solve._fraction

    def spy(self, x, du, *rest):
        moves.append(float(np.abs(du).max()))
        return fraction(self, x, du, *rest)

    monkeypatch.setattr(newton._Solve, "_fraction", spy)
    x = exact(1e-9, largest_move=1.5, max_iterations=500).solve(system, step.start.x, step, ONE).x
    assert x[0, 0] == pytest.approx(100.0, abs=1e-5)
    assert max(moves) <= 1.5 * (1.0 + 1e-12)
    assert len(moves) > 60


def test_a_negative_stiffness_is_climbed_out_of(spring, push):
    """From the top of a double well the damping and the line search lead down."""
    system, step = pulled(spring, push, 0.0, cubic=1.0, stiffness=-1.0)
    x0 = np.array([[0.05, 0.0, 0.0]])
    solution = exact(1e-10, max_iterations=60).solve(system, x0, step, ONE, damping=2.0)
    assert np.linalg.norm(solution.x) == pytest.approx(1.0, abs=1e-9)
    assert solution.iterations < 60


def test_a_solve_leaves_the_given_positions_alone(spring, push):
    system, step = pulled(spring, push, 10.0)
    guess = np.array([[0.5, 0.1, 0.0]])
    kept = guess.copy()
    exact(1e-10).solve(system, guess, step, ONE)
    np.testing.assert_array_equal(guess, kept)
