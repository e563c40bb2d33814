"""The bowline as a whole."""

import numpy as np
import pytest
from reduced import BENDING, RADIUS, SIDES, Rods, contact, peg, spec

from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.shipped import centreline_path
from knotfem.solver.stepping.controller import StepController
from knotfem.topology.knot_type import knot_type

UP = np.array([0.0, 0.0, 1.0])


def bowline(friction: float, cylinder: float, gravity: float) -> Rods:
    points = equal_chords(read_centreline(centreline_path("bowline")), 300, 600.0).points
    round_it = peg([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 10.0, cylinder)
    model = Rods([spec(points)], contact(friction), [round_it], gravity=-gravity * UP, drag=20.0)
    model.begin(*(model.clamped(side) for side in SIDES))
    go(model, 1.0)
    return model


def go(model: Rods, duration: float) -> list[tuple[float, float]]:
    """What friction and the time integration, with the error of the balance, took in each step."""
    sums = []
    before = model.energies
    for _ in model.steps(StepController(0.01, 1e-8, duration, RADIUS), model.time + duration):
        e = model.energies
        rest = e.algorithmic + e.error - before.algorithmic - before.error
        sums.append((e.friction - before.friction, rest))
        before = e
    return sums


@pytest.mark.slow
def test_pulled_until_it_locks():
    model = bowline(0.33, 0.39, 9810.0)
    kind, since = knot_type(model.centreline()).name, model.time
    model.begin(model.driven("start", UP, lambda time: 4.0 * (time - since)))
    forces = []
    for _ in range(3):
        taken = np.array(go(model, 33.0 / 4.0))
        forces.append(model.reaction("start") @ UP)
        assert taken[:, 0].min() > -1e-7 * model.energies.work
        assert taken[:, 1].min() > -1e-4 * model.energies.work
    assert knot_type(model.centreline()).name == kind
    assert forces[1] / forces[0] < 2.0
    assert forces[2] / forces[1] > 3.0
    assert model.penetration < 0.15 * 2 * RADIUS


def loaded(friction: float, cylinder: float, load: float) -> Rods:
    """At rest under a load, the free end held."""
    model = bowline(friction, cylinder, 0.0)
    held, since = model.clamped("end"), model.time
    model.begin(model.driven("start", UP, lambda time: 20.0 * (time - since)), held)
    while model.reaction("start") @ UP < load:
        go(model, 0.25)
    model.begin(model.loaded("start", lambda time: load * UP), held)
    go(model, 1.0)
    return model


def let_go(model: Rods, load: float, tail: float) -> None:
    """Replace what holds the free end by a fraction of the load."""
    model.begin(model.loaded("start", lambda time: load * UP), model.loaded("end", lambda time: tail * load * UP))


@pytest.mark.slow
@pytest.mark.parametrize(("tail", "share"), [(-0.05, 0.475), (0.05, 0.525)])
def test_tension_between_knot_and_a_slippery_cylinder(tail, share):
    """Half of what is above, by balance alone."""
    load = 2.01
    model = loaded(0.37, 0.0, load)
    let_go(model, load, tail)
    go(model, 1.0)
    c, tension = model.contacts(), model.tension()
    middles = (np.arange(tension.size) + 0.5) * model.layout.spacing[0]
    peg, knot = c.arclength[c.other < 0], c.arclength[c.other >= 0]
    leg = (middles > peg.max()) & (middles < knot[knot > peg.max()].min())
    assert np.median(tension[leg]) / load == pytest.approx(share, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "cylinder", "holds"), [(0.26, 0.0, True), (0.16, 0.0, False), (0.18, 0.39, True), (0.08, 0.39, False)]
)
def test_friction_decides_whether_the_bowline_stays(friction, cylinder, holds):
    """Under B/(9.1 r^2)."""
    load = BENDING / (9.1 * RADIUS**2)
    model = loaded(friction, cylinder, load)
    place = model.x[0, 2]
    let_go(model, load, -0.05)
    go(model, 10.0)
    assert (model.x[0, 2] - place < 40.0) == holds
    assert bool((model.contacts().other >= 0).any()) == holds
