"""An absent term and one whose coefficient is zero give the same result; what decides the type of the matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from derivatives import tangent
from specimens import accepted_steps, at_rest, cross_sections, make_core, make_rod, surfaces

from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.rigid import make_cylinder
from knotfem.contact.tube_friction import TubeFriction
from knotfem.contact.tube_obstacle_friction import TubeObstacleFriction
from knotfem.solver.constraints import driven, held
from knotfem.solver.nonlinear.line_search import Armijo
from knotfem.solver.nonlinear.newton import Newton
from knotfem.solver.nonlinear.tolerance import ForceTolerance
from knotfem.solver.schemes import BackwardEuler, Scheme
from knotfem.solver.system import System
from knotfem.solver.term import Term
from knotfem.solver.unknowns import Unknowns
from knotfem.sparse.linear import available, make_solver
from knotfem.terms.gravity import Gravity
from knotfem.terms.inertia import Drag, Inertia
from knotfem.terms.load import EndForce, FollowingForce
from knotfem.terms.viscous import ViscousDrag

SAME = 1e-12
"""Of the rods' length."""
LENGTH = 24.0
LAW = Penalty(stiffness=11.4, ramp=0.2)
STICK = 0.1


class Bench:
    """A rod clamped at one end and moved sideways at the other, onto a second rod that crosses it.

    Contact and cylinder are there for who asks for them.
    """

    def __init__(self, scheme: Scheme) -> None:
        self.scheme = scheme
        self.rods = [make_rod(LENGTH, 6, section=4), make_rod(LENGTH, 6, section=4, first=7 * 9)]
        assert self.rods[1].first == len(self.rods[0].mesh.nodes)
        first, second = (rod.mesh.nodes - [0.0, 0.0, 0.5 * LENGTH] for rod in self.rods)
        turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        self.x = np.vstack([first, second @ turn.T + [5.95, 0.0, 0.0]])
        self.mass = np.concatenate([rod.mass for rod in self.rods])
        self.surface, self.samples = surfaces(self.rods, 1.5)
        self.contact = PairContact(self.surface, self.samples, LAW)
        self.cylinder = self.obstacle(LAW)

    def obstacle(self, law: Penalty) -> ObstacleContact:
        rigid = make_cylinder(np.array([-7.95, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), 5.0)
        return ObstacleContact(self.surface, self.samples, law, rigid)

    def friction(self, mu: float) -> Friction:
        return Friction(self.contact, TubeFriction(STICK), np.full((2, 2), mu))

    def cylinder_friction(self, mu: float) -> Friction:
        return Friction(self.cylinder, TubeObstacleFriction(STICK), np.full(2, mu), scheduled=False)

    def run(self, *more: Term) -> np.ndarray:
        """Positions after three steps of the rods with some terms."""
        rod = self.rods[0]
        x, ends = self.x, (rod.sections[0], rod.sections[-1])
        others = np.concatenate([self.rods[1].sections[0], self.rods[1].sections[-1]])
        motions = [
            held(ends[0], x[ends[0]]),
            held(others, x[others]),
            driven(ends[1], x[ends[1]], np.array([1.0, 0.0, 0.0]), lambda time: 0.6 * time),
        ]
        terms = [*(rod.bulk for rod in self.rods), *more]
        self.system = System(terms, Unknowns(len(x)), make_solver("auto"), self.scheme, motions)
        newton = Newton(ForceTolerance(1e-10, 1e-9), Armijo(whole_below=10.0), max_iterations=40, largest_move=10.0)
        sections = cross_sections(*self.rods)
        steps = list(
            accepted_steps(self.system, at_rest(x), sections, [0.3], first=0.1, largest=0.1, move=100.0, newton=newton)
        )
        assert [step.rejected for step in steps] == [0, 0, 0]
        return steps[-1].state.x


def _edges(bench: Bench) -> np.ndarray:
    return np.concatenate([rod.edges for rod in bench.rods])


ZERO: dict[str, Callable[[Bench], tuple[list[Term], Term]]] = {
    "core": lambda b: ([], make_core(_edges(b), LENGTH / 6, 0.0)),
    "inertia": lambda b: ([], Inertia(0.0 * b.mass)),
    "drag": lambda b: ([], Drag(b.mass, 0.0)),
    "gravity": lambda b: ([], Gravity(b.mass, np.zeros(3))),
    "viscous_drag": lambda b: ([], ViscousDrag(_edges(b), np.full(12, LENGTH / 6), 0.0, 0.0)),
    "load": lambda b: ([], EndForce(b.rods[0].sections[3], b.rods[0].end_weights, lambda time: np.zeros(3))),
    "following load": lambda b: (
        [],
        FollowingForce(
            b.rods[0].sections[3], b.rods[0].end_weights, b.rods[0].axis[2], b.rods[0].axis[3], lambda time: 0.0
        ),
    ),
    "contact": lambda b: ([], PairContact(b.surface, b.samples, LAW._replace(stiffness=0.0))),
    "friction": lambda b: ([b.contact], b.friction(0.0)),
    "cylinder": lambda b: ([], b.obstacle(LAW._replace(stiffness=0.0))),
    "cylinder friction": lambda b: ([b.cylinder], b.cylinder_friction(0.0)),
}


@pytest.mark.parametrize("scheme", [Scheme(), BackwardEuler()], ids=lambda scheme: type(scheme).__name__)
@pytest.mark.parametrize("name", list(ZERO))
def test_coefficient_zero_is_the_same_as_absence(name: str, scheme: Scheme) -> None:
    if name == "inertia":
        scheme = BackwardEuler()
    with_it, without = Bench(scheme), Bench(scheme)
    before, zero = ZERO[name](with_it)
    assert np.abs(with_it.run(*before, zero) - without.run(*ZERO[name](without)[0])).max() <= SAME * LENGTH
    assert with_it.system.clock.calls[zero.name] > 0
    assert zero.name not in without.system.clock.calls


@pytest.mark.parametrize("name", ["drag", "gravity", "contact", "friction", "cylinder", "cylinder friction"])
def test_the_bench_would_notice(name: str) -> None:
    """With a coefficient that is not zero each term moves the rods by more than a hundred times what is allowed."""
    bench = Bench(Scheme())
    terms = {
        "drag": ([], Drag(bench.mass, 100.0)),
        "gravity": ([], Gravity(bench.mass, np.array([0.0, 9810.0, 0.0]))),
        "contact": ([], bench.contact),
        "friction": ([bench.contact], bench.friction(0.3)),
        "cylinder": ([], bench.cylinder),
        "cylinder friction": ([bench.cylinder], bench.cylinder_friction(0.3)),
    }
    before, term = terms[name]
    moved = bench.run(*before, term)
    assert np.abs(moved - Bench(Scheme()).run(*before)).max() > 100.0 * SAME * LENGTH


def test_contact_without_friction_has_a_symmetric_tangent() -> None:
    bench = Bench(Scheme())
    x = bench.run(bench.contact)
    assert bench.contact.touching >= 2
    full = tangent([bench.contact], x)
    assert np.abs(full).max() > 1.0
    assert np.abs(full - full.T).max() <= 1e-12 * np.abs(full).max()
    upper = tangent([bench.contact], x, upper=True)
    np.testing.assert_allclose(upper, full, atol=1e-12 * np.abs(full).max())


def test_only_friction_and_following_loads_take_the_symmetry() -> None:
    bench = Bench(BackwardEuler())
    symmetric = {name: ZERO[name](bench)[1].symmetric for name in ZERO}
    assert [name for name, value in symmetric.items() if not value] == [
        "following load", "friction", "cylinder friction",
    ]  # fmt: skip


@pytest.mark.parametrize(("rubs", "kind"), [(False, -2), (True, 11)])
def test_pardiso_is_told_the_type_of_the_matrix(rubs: bool, kind: int) -> None:
    bench = Bench(Scheme())
    bench.run(bench.contact, *([bench.friction(0.3)] if rubs else []))
    assert bench.system.symmetric is not rubs
    assert bench.system._build().pattern.upper is not rubs
    if available()[0] == "pardiso":
        assert vars(bench.system.solver)["_type"] == kind
