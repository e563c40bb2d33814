import numpy as np
import pytest
from derivatives import gradient_error
from specimens import at_rest, make_rod

from knotfem.solver.constraints import Prescribed, held
from knotfem.solver.schemes import BackwardEuler, Scheme, generalised_alpha, hht
from knotfem.solver.state import Motion, State
from knotfem.solver.system import System
from knotfem.solver.term import Role
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import make_solver
from knotfem.terms.inertia import Drag, Inertia
from knotfem.terms.load import EndForce, FollowingForce


def test_components_of_one_node_may_be_prescribed_apart(spring):
    nodes = np.array([1, 3])
    where = np.arange(6.0).reshape(2, 3)
    system = System(
        [spring(1.0)],
        Unknowns(4),
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


def test_symmetric_storage_only_where_every_term_is(spring):
    rod = make_rod(6.0, 4)
    x = rod.mesh.nodes
    following = FollowingForce(rod.sections[-1], rod.end_weights, int(rod.axis[-2]), int(rod.axis[-1]), lambda t: t)
    for terms, symmetric in (([rod.bulk], True), ([rod.bulk, following], False)):
        system = System(terms, Unknowns(len(x)), make_solver("superlu"), Scheme())
        system.begin(at_rest(x), 1.0)
        _, matrix = system.tangent(x)
        assert matrix.pattern.upper is symmetric


@pytest.mark.parametrize("scheme", [Scheme(), BackwardEuler(), hht(-0.2)], ids=["static", "euler", "hht"])
def test_tangent_is_the_derivative_of_the_residual(scheme):
    rod = make_rod(6.0, 4, core_stiffness=50.0)
    x = rod.mesh.nodes + 0.05 * np.random.default_rng(0).standard_normal(rod.mesh.nodes.shape)
    terms = [*rod.terms, Drag(rod.mass, 20.0)]
    if scheme.inertial:
        terms.append(Inertia(rod.mass))
    system = System(terms, Unknowns(len(x)), make_solver("superlu"), scheme)
    system.begin(at_rest(rod.mesh.nodes), 1e-4)
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
    system = System(
        rod.terms, Unknowns(len(x)), make_solver("auto"), Scheme(), [held(rod.sections[0], x[rod.sections[0]])]
    )
    system.begin(at_rest(x), 1.0)
    for _ in range(3):
        _, matrix = system.tangent(x)
        system.solve(matrix, 0.0, np.ones_like(x))
    assert (system.analyses, system.factorisations) == (1, 3)
    system.drop_pattern()
    _, matrix = system.tangent(x)
    system.solve(matrix, 0.0, np.ones_like(x))
    assert system.analyses == 2
    system.close()


def test_solution_vanishes_where_prescribed_and_damping_acts_by_weight(spring):
    system = System(
        [spring(2.0)], Unknowns(2, damping_weights=np.array([0.25, 0.75])), make_solver("superlu"), Scheme()
    )
    x = np.ones((2, 3))
    system.begin(at_rest(x), 1.0)
    _, matrix = system.tangent(x)
    np.testing.assert_allclose(system.solve(matrix, 4.0, x), [[1 / 3] * 3, [1 / 5] * 3])
    fixed = System([spring(2.0)], Unknowns(2), make_solver("superlu"), Scheme(), [held(np.array([0]), x[:1])])
    fixed.begin(at_rest(x), 1.0)
    _, matrix = fixed.tangent(x)
    np.testing.assert_allclose(fixed.solve(matrix, 0.0, x), [[0.0] * 3, [0.5] * 3])


def test_forces_by_label_sum_to_the_residual():
    rod = make_rod(6.0, 4, core_stiffness=50.0)
    x = 1.01 * rod.mesh.nodes
    loads = [EndForce(rod.sections[k], rod.end_weights, lambda t: np.array([0.0, 0.0, t])) for k in (0, -1)]
    system = System([*rod.terms, *loads], Unknowns(len(x)), make_solver("superlu"), Scheme())
    system.begin(at_rest(x), 1.0)
    forces = system.forces(x)
    assert list(forces) == ["elasticity-1", "core-1", "load-1", "load-2"]
    np.testing.assert_allclose(sum(forces.values()), system.residual(x), atol=1e-13)
    assert (forces["load-1"] + forces["load-2"])[:, 2].sum() == pytest.approx(-2.0)
    assert system.having(Role.LOAD) == loads
    assert system.labels["load-2"] is loads[1]
    assert system.having(Role.ELASTIC, Role.LOAD) == system.terms


def test_terms_that_others_may_lack_keep_the_number_of_what_they_belong_to(spring):
    first, numbered = spring(1.0), spring(1.0)
    numbered.number = 3
    system = System([first, numbered], Unknowns(1), make_solver("superlu"), Scheme())
    assert list(system.labels) == ["spring-1", "spring-3"]


def test_slope_of_the_merit_is_the_residual_in_every_scheme(spring, push):
    mass = np.ones(2)
    for scheme in (Scheme(), BackwardEuler(), hht(-0.3), generalised_alpha(0.5)):
        inertia = [Inertia(mass)] if scheme.inertial else []
        terms = [spring(3.0, 0.2), push(lambda time: np.array([5.0 * time, 1.0, 0.0])), *inertia]
        system = System(terms, Unknowns(2), make_solver("superlu"), scheme)
        start = Motion(np.array([[1.0, 0.2, 0.0], [0.0, 0.5, 0.3]]), np.ones((2, 3)), np.full((2, 3), 2.0), 0.5)
        system.begin(State.of(start, {}), 0.3)
        x = start.x + 0.1
        assert gradient_error(system.merit, system.residual(x), x) < 1e-8


def test_history_comes_back_to_the_bit_and_by_place():
    first = make_rod(6.0, 4, core_stiffness=50.0)
    second = make_rod(6.0, 4, core_stiffness=50.0, first=len(first.mesh.nodes))
    x = np.vstack([first.mesh.nodes, first.mesh.nodes + 20.0])
    system = System([*first.terms, *second.terms], Unknowns(len(x)), make_solver("superlu"), Scheme())
    system.begin(at_rest(x), 1.0)
    system.tangent(x)
    assert first.core is not None
    assert second.core is not None
    second.core.force[:] += 3.0
    state = system.state(Motion.at_rest(x))
    assert set(state.history) == {"elasticity-1", "core-1", "elasticity-2", "core-2"}
    first.core.force[:] += 1.0
    second.bulk.pressure[:] -= 1.0
    system.load(state)
    assert (first.core.force == 0.0).all()
    assert (second.core.force == 3.0).all()
    assert (second.bulk.pressure == 0.0).all()


def test_terms_that_a_state_does_not_know_begin_anew(spring):
    known, fresh = spring(1.0), spring(1.0)
    system = System([known, fresh], Unknowns(1), make_solver("superlu"), Scheme())
    known.accepted[:], fresh.accepted[:] = 5.0, 7.0
    system.load(State.of(Motion.at_rest(np.ones((1, 3))), {"spring-1": {"accepted": np.array([2.0])}}))
    assert (known.accepted[0], fresh.accepted[0]) == (2.0, 0.0)


def test_a_committed_state_is_a_value(spring):
    """What happens to the terms and to the positions afterwards does not change it; nor does the next step."""
    hanging = spring(1.0)
    system = System([hanging], Unknowns(1), make_solver("superlu"), Scheme())
    start = at_rest(np.zeros((1, 3)), 2.0)
    x = np.array([[0.5, 0.0, 0.0]])
    step = system.begin(start, 0.25)
    assert (step.start, step.dt, step.end) == (start, 0.25, 2.25)
    state = system.commit(x, step)
    assert state.time == 2.25
    x += 1.0
    hanging.accepted += 1.0
    np.testing.assert_array_equal(state.x, [[0.5, 0.0, 0.0]])
    np.testing.assert_array_equal(state.v, [[2.0, 0.0, 0.0]])
    assert state.history["spring-1"]["accepted"] == 0.5
    hanging.load(state.history["spring-1"])
    system.commit(state.x + 1.0, system.begin(state, 0.25))
    assert hanging.accepted == 2.0
    assert state.history["spring-1"]["accepted"] == 0.5
    np.testing.assert_array_equal(start.x, 0.0)


def test_pattern_of_an_earlier_system_gives_the_same_matrix():
    rod = make_rod(6.0, 4)
    x = rod.mesh.nodes
    following = FollowingForce(rod.sections[-1], rod.end_weights, int(rod.axis[-2]), int(rod.axis[-1]), lambda t: t)
    before = System([rod.bulk, following], Unknowns(len(x)), make_solver("superlu"), Scheme())
    before.begin(at_rest(x), 1.0)
    before.tangent(x)
    later = System([rod.bulk], Unknowns(len(x), unsymmetric=True), make_solver("superlu"), Scheme())
    assert before.keys is not None
    later.restore_pattern(before.keys)
    later.begin(at_rest(x), 1.0)
    _, matrix = later.tangent(x)
    np.testing.assert_array_equal(matrix.pattern.node_adj, before.tangent(x)[1].pattern.node_adj)
    np.testing.assert_array_equal(later.keys, before.keys)


def test_a_step_may_be_begun_twice_with_the_weighed_start_residual(spring, push):
    """A first attempt must not leave its loads or speeds in the residual that the second sets out with."""
    scheme = hht(-0.3)
    mass = np.ones(1)
    residuals = []
    for tried in (False, True):
        terms = [
            spring(3.0),
            push(lambda time: np.array([5.0 * time, 0.0, 0.0])),
            Drag(mass, 2.0),
            Inertia(mass),
        ]
        system = System(terms, Unknowns(1), make_solver("superlu"), scheme)
        motion = Motion(np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 2.0, 0.0]]), np.zeros((1, 3)), 4.0)
        state = State.of(motion, {})
        if tried:
            system.begin(state, 7.0)
        system.begin(state, 0.1)
        residuals.append(system.residual(motion.x + 0.1))
    np.testing.assert_array_equal(*residuals)
