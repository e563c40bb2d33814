"""What contacts remember goes through `history` and `load` alone, by all four laws of friction."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from knotfem.contact.curve import make_samples
from knotfem.contact.curve_friction import CurveFriction
from knotfem.contact.curve_obstacle_friction import CurveObstacleFriction
from knotfem.contact.curve_pairs import CurveSurface
from knotfem.contact.friction import Friction
from knotfem.contact.law import Penalty
from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.contact.rigid import make_cylinder
from knotfem.mesh.rod_layout import make_layout
from knotfem.models.rod.frames import Frames
from knotfem.solver.state import Motion
from knotfem.solver.term import Conditions, Term, TimeStep
from knotfem.types import Arrays

LAW = Penalty(0.5, 0.2)


def discrete(obstacle: bool) -> tuple[list[Term], np.ndarray]:
    """Two crossed discrete rods, or one of them on a cylinder, with friction."""
    layout = make_layout([12, 12], [2.0, 2.0], [3.0, 3.0])
    x = np.zeros((layout.nodes, 4))
    s = 2.0 * (np.arange(13) - 6.0)
    first, second = layout.of(0), layout.of(1)
    x[first, 2] = s
    x[second, 0], x[second, 1], x[second, 2] = 5.8, np.cos(0.3) * s, np.sin(0.3) * s
    x[:, :3] += 0.02 * np.random.default_rng(1).standard_normal((layout.nodes, 3))
    frames = Frames(layout, x, np.tile([0.3, 0.5, 0.7], (layout.nodes, 1)))
    surface, samples = CurveSurface(layout), make_samples(layout, 0.75)
    if obstacle:
        cylinder = make_cylinder(np.array([18.6, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), 10.0)
        contact = ObstacleContact(surface, samples, LAW, cylinder)
        return [frames, contact, Friction(contact, CurveObstacleFriction(frames, 0.1), np.full(2, 0.4))], x
    pairs = PairContact(surface, samples, LAW)
    return [frames, pairs, Friction(pairs, CurveFriction(frames, 0.3), np.full((2, 2), 0.4))], x


Make = Callable[[], tuple[list[Term], np.ndarray]]


@pytest.fixture(params=["tubes", "tubes on a cylinder", "discrete rods", "discrete rods on a cylinder"])
def make(request, make_crossing, make_rest) -> Make:
    """The same terms anew each time, and where they begin."""

    def made() -> tuple[list[Term], np.ndarray]:
        if request.param.startswith("discrete"):
            return discrete("cylinder" in request.param)
        if "cylinder" in request.param:
            rest = make_rest()
            return [rest.contact, rest.friction], rest.x
        crossing = make_crossing()
        return [crossing.contact, crossing.friction], crossing.x

    return made


def take(terms: list[Term], start: np.ndarray, x: np.ndarray, conditions: Conditions) -> tuple[bytes, list[Arrays]]:
    """One step as a system takes it: the residual at its end, and the histories after it."""
    step = TimeStep(Motion.at_rest(start), 0.1, conditions=conditions)
    for term in terms:
        term.update(start)
    for term in terms:
        term.begin(step)
    for term in terms:
        term.update(x)
    residual = np.zeros_like(x)
    for term in terms:
        term.assemble(x, residual, None)
    for term in terms:
        term.commit(x)
    return residual.tobytes(), [term.history() for term in terms]


def load(terms: list[Term], histories: list[Arrays]) -> None:
    for term, history in zip(terms, histories, strict=True):
        term.load(history)


def bits(histories: list[Arrays]) -> list[dict[str, bytes]]:
    return [{name: value.tobytes() for name, value in history.items()} for history in histories]


def path(x: np.ndarray, steps: int) -> list[np.ndarray]:
    """The second half of the nodes dragged across the first, so far that pairs slide and are searched anew."""
    found = [x]
    half = len(x) // 2
    for _ in range(steps):
        y = found[-1].copy()
        y[half:, 1:3] += [0.07, 0.11]
        found.append(y)
    return found


CONDITIONS = [Conditions(), Conditions(friction=lambda time: 0.75), Conditions(), Conditions()]


def test_other_terms_go_on_to_the_same_bits(make):
    terms, x = make()
    places = path(x, 4)
    taken = [take(terms, *pair) for pair in zip(places[:-1], places[1:], CONDITIONS, strict=True)]
    assert terms[-1].sliding > 0
    other, _ = make()
    load(other, taken[1][1])
    for k in (2, 3):
        residual, histories = take(other, places[k], places[k + 1], CONDITIONS[k])
        assert residual == taken[k][0]
        assert bits(histories) == bits(taken[k][1])


def test_the_same_terms_go_back_and_on_again_to_the_same_bits(make):
    """After a step that was tried and dropped, and after steps that were accepted."""
    terms, x = make()
    places = path(x, 4)
    taken = [take(terms, *pair) for pair in zip(places[:-1], places[1:], CONDITIONS, strict=True)]
    kept = bits(taken[1][1])
    for far in (0.0, 0.4):
        take(terms, places[2], places[2] + far, Conditions(friction=lambda time: 0.1))
        load(terms, taken[1][1])
        residual, histories = take(terms, places[2], places[3], CONDITIONS[2])
        assert residual == taken[2][0]
        assert bits(histories) == bits(taken[2][1])
    assert bits(taken[1][1]) == kept


def test_empty_history_is_that_with_which_a_term_begins(make):
    terms, x = make()
    places = path(x, 2)
    first = take(terms, places[0], places[1], CONDITIONS[0])
    take(terms, places[1], places[2], CONDITIONS[1])
    load(terms, [{} for _ in terms])
    again = take(terms, places[0], places[1], CONDITIONS[0])
    assert again[0] == first[0]
    assert bits(again[1]) == bits(first[1])


def test_slip_is_the_distance_that_a_step_drags_contacts(make):
    """The first step lies within the stick distance in part; from then on contacts follow what drags them."""
    terms, x = make()
    places = path(x, 6)
    take(terms, x, x, Conditions())
    assert terms[-1].slip() == 0.0
    for pair in pairwise(places):
        take(terms, *pair, Conditions())
    assert terms[-1].slip() == pytest.approx(np.hypot(0.07, 0.11), rel=0.15)
