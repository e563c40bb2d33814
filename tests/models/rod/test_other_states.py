"""What is asked about other states leaves the terms of a phase that is under way as they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from reduced import RADIUS, Rods, begun, contact, line, peg, settle, spec

import knotfem as kf
from knotfem.models.base import Additions, Model, RigidMotion
from knotfem.models.rod.model import RodModel
from knotfem.run.events import TimeStepDone
from knotfem.run.simulation import Simulation
from knotfem.scene.model import Scene
from knotfem.solver.schemes import Scheme
from knotfem.solver.state import State
from knotfem.solver.stepping.controller import StepController
from knotfem.solver.system import System
from knotfem.solver.term import Term, TimeStep
from knotfem.types import Arrays

SHAFT = (
    "model=rod",
    "rods.0.length=40 mm",
    "rods.0.mesh.element_length=4 mm",
    "rods.0.material.relaxation_time=0.02 s",
    "inertia.scheme=backward-euler",
    "solver.threads=1",
    'steps=[{kind="turn", duration="0.4 s", ends={rod={start={motion="turned", turns=2}, end={motion="free"}}}}]',
)


def shaft() -> Scene:
    """A sagging rod that is turned twice at one end and free at the other."""
    return kf.load_scene("cantilever", SHAFT)


class Asks(Term):
    """A user's term that exerts no force and asks for the direction of a free end, in the state a step sets out from.

    Args:
        model: whose end it is.
    """

    name = "asks"

    def __init__(self, model: Model) -> None:
        self.model = model

    def begin(self, step: TimeStep) -> None:
        assert isinstance(step.start, State)
        self.model.outward(0, "end", step.start)


def ends(additions: Additions | None = None, between: Callable[[RodModel, State], object] | None = None) -> list[State]:
    """Accepted states of the shaft.

    Args:
        additions: of the user's own.
        between: called after each step, with the state that the shaft began in, both ends free.
    """
    simulation, found = Simulation(shaft(), additions=additions), []
    assert isinstance(simulation.model, RodModel)
    first = simulation.model.discrete.clamped(simulation.model.straight(), [])
    for event in simulation.run():
        if isinstance(event, TimeStepDone):
            found.append(event.state)
            if between is not None:
                between(simulation.model, first)
    return found


def same(one: State, other: State) -> None:
    np.testing.assert_array_equal(one.x, other.x)
    np.testing.assert_array_equal(one.v, other.v)
    for label, history in other.history.items():
        equal(one.history[label], history)


def equal(one: Arrays, other: Arrays) -> None:
    assert set(one) == set(other)
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name])


def ask_clamped(model: RodModel, state: State) -> None:
    model.discrete.clamped(state, [])


def ask_outward(model: RodModel, state: State) -> None:
    model.outward(0, "end", state)


def ask_constrained(model: RodModel, state: State) -> None:
    model.constrained(0, "end", RigidMotion(), model.origin(state))


def ask_adapted(model: RodModel, state: State) -> None:
    equations = model.equations(model.scene.steps[0], model.origin(state), {})
    model.adapted(state, equations)
    equations.system.close()


ASKED = [ask_clamped, ask_outward, ask_constrained, ask_adapted]


@pytest.fixture(scope="module")
def undisturbed() -> list[State]:
    return ends()


@pytest.mark.parametrize("ask", ASKED)
def test_the_terms_keep_their_history(ask: Callable[[RodModel, State], None]) -> None:
    simulation = Simulation(shaft())
    model, checked = simulation.model, 0
    assert isinstance(model, RodModel)
    first = model.discrete.clamped(model.straight(), [])
    for event in simulation.run():
        if not isinstance(event, TimeStepDone):
            continue
        system = event.system
        before = system.history()
        ask(model, first)
        after = system.history()
        assert set(after) == set(before)
        for label, history in before.items():
            equal(after[label], history)
        checked += 1
        if checked == 4:
            break
    assert checked == 4


@pytest.mark.parametrize("ask", ASKED)
def test_a_phase_goes_on_to_the_same_bits(ask: Callable[[RodModel, State], None], undisturbed: list[State]) -> None:
    asked = ends(between=ask)
    assert len(asked) == len(undisturbed) > 4
    for one, other in zip(asked, undisturbed, strict=True):
        same(one, other)


def test_a_term_that_asks_for_the_direction_of_an_end_lets_the_clamps_turn(undisturbed: list[State]) -> None:
    asked = ends(Additions(terms=[Asks]))
    assert np.abs(undisturbed[-1].x[:, 3]).max() > RADIUS
    assert len(asked) == len(undisturbed)
    for one, other in zip(asked, undisturbed, strict=True):
        same(one, other)


def test_a_model_stands_in_its_initial_state_before_the_first_step() -> None:
    model = RodModel(shaft())
    assert model.clamp_couples(model.straight().x).shape == (2, 3)


def test_contact_and_friction_keep_their_history() -> None:
    lower = line(12, 36.0) - np.array([18.0, 0.0, 0.0])
    upper = line(12, 36.0, axis=1) + np.array([0.0, -18.0, 2 * RADIUS - 0.1])
    below = peg([0.0, 0.0, -10.0 - RADIUS], [0.0, 1.0, 0.0], 10.0, 0.2)
    model = Rods([spec(lower), spec(upper, relaxation_time=0.01)], contact(0.3), [below], drag=20.0)
    press = model.loaded("end", lambda t: np.array([0.06 * t, 0.02 * t, -0.05]), rod=1)
    begun(model, model.clamped("start"), model.pinned("start", rod=1), press)
    first = model.discrete.initial
    model.run(StepController(0.01, 1e-6, 0.05, RADIUS), 0.1)
    before = model.system.history()
    assert np.abs(model.friction.view.stored).max() > 0.0
    model.discrete.clamped(first, [])
    after = model.system.history()
    assert set(after) == set(before)
    for label, history in before.items():
        equal(after[label], history)


def test_rods_with_internal_damping_set_out_from_their_initial_state() -> None:
    rods = Rods([spec(line(4, 8.0), relaxation_time=0.02)], scheme=Scheme()).discrete
    system: System = rods.system(Scheme(), fixed=np.ones((5, 4), dtype=bool))
    start = rods.initial
    after = system.commit(start.x, system.begin(start, 0.1))
    np.testing.assert_array_equal(after.x, start.x)
    assert {label for label in start.history if label.startswith("internal damping")} == {
        label for label, term in system.labels.items() if term.name == "internal damping"
    }
    system.close()


def test_the_axial_force_of_the_damping_goes_on_from_that_of_the_state() -> None:
    """Not from the state last loaded."""
    model = Rods([spec(line(4, 8.0), axial=200.0, relaxation_time=0.02)], scheme=Scheme())
    first = model.state
    settle(model, model.clamped("start"), model.loaded("end", lambda t: np.array([2.0 * t, 0.0, 0.0])))
    forces = [
        model.discrete.clamped(state, []).history["internal damping-1"]["force"] for state in (first, model.state)
    ]
    np.testing.assert_array_equal(forces[0], first.history["internal damping-1"]["force"])
    np.testing.assert_array_equal(forces[1], model.state.history["internal damping-1"]["force"])
    assert np.abs(forces[1]).max() > 0.0
