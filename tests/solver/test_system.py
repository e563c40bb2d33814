import numpy as np
import pytest
from derivatives import gradient_error
from specimens import make_rod

from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.system import System
from knotfem.solver.term import Motion, StepStart
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag, Inertia
from knotfem.terms.load import EndForce, FollowingForce


def test_components_of_one_node_may_be_prescribed_apart(spring):
    nodes = np.array([1, 3])
    where = np.arange(6.0).reshape(2, 3)
    system = System(
        [spring(1.0)],
        4,
        make_solver("superlu"),
        Scheme(),
        [
            Prescribed(nodes, lambda time: where + time, components=(True, False, False)),
            Prescribed(nodes[:1], lambda time: -where[:1], components=(False, False, True)),
        ],
    )
    np.testing.assert_array_equal(system.fixed[1], [True, False, True])
    np.testing.assert_array_equal(system.fixed[3], [True, False, False])
    assert np.count_nonzero(system.fixed) == 3
    goal = system.targets(2.0)
    assert (goal[1, 0], goal[1, 2], goal[3, 0]) == (2.0, -2.0, 5.0)


def test_symmetric_storage_only_where_every_effect_is(spring):
    rod = make_rod(6.0, 4)
    x = rod.mesh.nodes
    following = FollowingForce(rod.sections[-1], rod.end_weights, int(rod.axis[-2]), int(rod.axis[-1]), lambda t: t)
    for effects, symmetric in (([rod.bulk], True), ([rod.bulk, following], False)):
        system = System(effects, len(x), make_solver("superlu"), Scheme())
        system.begin(StepStart(Motion.at_rest(x), 1.0))
        _, matrix = system.tangent(x)
        assert matrix.pattern.upper is symmetric


@pytest.mark.parametrize("scheme", [Scheme(), BackwardEuler(), hht(-0.2)], ids=["static", "euler", "hht"])
def test_tangent_is_the_derivative_of_the_residual(scheme):
    rod = make_rod(6.0, 4, core_stiffness=50.0)
    x = rod.mesh.nodes + 0.05 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    effects = [*rod.effects, Drag(rod.mass, 20.0)]
    if scheme.inertial:
        effects.append(Inertia(rod.mass))
    system = System(effects, len(x), make_solver("superlu"), scheme)
    system.begin(StepStart(Motion.at_rest(rod.mesh.nodes), 1e-4))
    system.residual(x)
    system.increment(np.zeros_like(x))
    system.advance(1.0)
    _, matrix = system.tangent(x)
    d = np.random.default_rng(1).standard_normal(x.shape)
    expected = (system.residual(x + 1e-6 * d) - system.residual(x - 1e-6 * d)) / 2e-6
    found = matrix.multiply(d.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_analysis_is_kept_while_the_pattern_holds():
    rod = make_rod(6.0, 4)
    x = rod.mesh.nodes
    system = System(rod.effects, len(x), make_solver("auto"), Scheme(), [held(rod.sections[0], x[rod.sections[0]])])
    system.begin(StepStart(Motion.at_rest(x), 1.0))
    for _ in range(3):
        _, matrix = system.tangent(x)
        system.solve(matrix, 0.0, np.ones_like(x))
    assert (system.analyses, system.factorisations) == (1, 3)
    system.drop_pattern()
    _, matrix = system.tangent(x)
    system.solve(matrix, 0.0, np.ones_like(x))
    assert system.analyses == 2
    system.close()


def test_solution_vanishes_where_prescribed_and_shift_acts_by_weight(spring):
    system = System([spring(2.0)], 2, make_solver("superlu"), Scheme(), shift_weights=np.array([0.25, 0.75]))
    x = np.ones((2, 3))
    system.begin(StepStart(Motion.at_rest(x), 1.0))
    _, matrix = system.tangent(x)
    np.testing.assert_allclose(system.solve(matrix, 4.0, x), [[1 / 3] * 3, [1 / 5] * 3])
    fixed = System([spring(2.0)], 2, make_solver("superlu"), Scheme(), [held(np.array([0]), x[:1])])
    fixed.begin(StepStart(Motion.at_rest(x), 1.0))
    _, matrix = fixed.tangent(x)
    np.testing.assert_allclose(fixed.solve(matrix, 0.0, x), [[0.0] * 3, [0.5] * 3])


def test_forces_by_name_sum_to_the_residual():
    rod = make_rod(6.0, 4, core_stiffness=50.0)
    x = 1.01 * rod.mesh.nodes
    loads = [EndForce(rod.sections[k], rod.end_weights, lambda t: np.array([0.0, 0.0, t])) for k in (0, -1)]
    system = System([*rod.effects, *loads], len(x), make_solver("superlu"), Scheme())
    system.begin(StepStart(Motion.at_rest(x), 1.0))
    forces = system.forces(x)
    assert set(forces) == {"elasticity", "core", "load"}
    np.testing.assert_allclose(sum(forces.values()), system.residual(x), atol=1e-13)
    assert forces["load"][:, 2].sum() == pytest.approx(-2.0)
    assert len(system.effect("load")) == 2


def test_slope_of_the_merit_is_the_residual_in_every_scheme(spring, push):
    mass = np.ones(2)
    for scheme in (Scheme(), BackwardEuler(), hht(-0.3), generalised_alpha(0.5)):
        inertia = [Inertia(mass)] if scheme.inertial else []
        effects = [spring(3.0, 0.2), push(lambda time: np.array([5.0 * time, 1.0, 0.0])), *inertia]
        system = System(effects, 2, make_solver("superlu"), scheme)
        start = Motion(np.array([[1.0, 0.2, 0.0], [0.0, 0.5, 0.3]]), np.ones((2, 3)), np.full((2, 3), 2.0), 0.5)
        system.begin(StepStart(start, 0.3))
        x = start.x + 0.1
        assert gradient_error(system.merit, system.residual(x), x) < 1e-8


def test_memory_comes_back_to_the_bit_and_by_place():
    first = make_rod(6.0, 4, core_stiffness=50.0)
    second = make_rod(6.0, 4, core_stiffness=50.0, first=len(first.mesh.nodes))
    x = np.vstack([first.mesh.nodes, first.mesh.nodes + 20.0])
    system = System([*first.effects, *second.effects], len(x), make_solver("superlu"), Scheme())
    system.begin(StepStart(Motion.at_rest(x), 1.0))
    system.tangent(x)
    second.core.force += 3.0
    history = system.history()
    assert {"elasticity-1", "core-1", "elasticity-2", "core-2", "pattern"} == set(history)
    first.core.force += 1.0
    second.bulk.pressure -= 1.0
    system.load(history)
    assert (first.core.force == 0.0).all()
    assert (second.core.force == 3.0).all()
    assert (second.bulk.pressure == 0.0).all()


def test_a_step_may_be_begun_twice_with_the_weighed_start_residual(spring, push):
    """A first attempt must not leave its loads or speeds in the residual that the second sets out with."""
    scheme = hht(-0.3)
    mass = np.ones(1)
    residuals = []
    for tried in (False, True):
        effects = [
            spring(3.0),
            push(lambda time: np.array([5.0 * time, 0.0, 0.0])),
            Drag(mass, 2.0),
            Inertia(mass),
        ]
        system = System(effects, 1, make_solver("superlu"), scheme)
        motion = Motion(np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 2.0, 0.0]]), np.zeros((1, 3)), 4.0)
        if tried:
            system.begin(StepStart(motion, 7.0))
        system.begin(StepStart(motion, 0.1))
        residuals.append(system.residual(motion.x + 0.1))
    np.testing.assert_array_equal(*residuals)
