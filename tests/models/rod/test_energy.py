"""The energy balance: nothing comes from nothing, friction only takes."""

import numpy as np
import pytest
from reduced import RADIUS, SIDES, Rods, begun, contact, line, spec, still

from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.shipped import centreline_path
from knotfem.solver.schemes import hht
from knotfem.solver.stepping.controller import StepController
from knotfem.topology.knot_type import knot_type

GRAVITY = np.array([0.0, 0.0, -9810.0])


def test_a_free_swing_keeps_its_energy():
    model = Rods([spec(line(12, 60.0))], gravity=GRAVITY, scheme=hht(0.0))
    model.begin(model.clamped("start"))
    scale, worst = 0.0, 0.0
    for _ in model.steps(StepController(5e-4, 1e-6, 5e-4, 1e3), 0.05, newton=model.newton(1e-8)):
        e = model.energies
        scale = max(scale, e.kinetic)
        worst = max(worst, abs(e.algorithmic), abs(e.error), abs(e.algorithmic + e.error))
    assert scale > 0.01
    assert worst < 2e-3 * scale


def test_work_of_a_driven_end_is_stored():
    model = still(line(20, 60.0))
    force = np.array([0.0, 0.02, 0.0])
    model.begin(model.clamped("start"), model.loaded("end", lambda t: t * force))
    model.run(StepController(0.05, 1e-3, 0.05, 1e3), 1.0, newton=model.newton(1e-9))
    e = model.energies
    assert e.elastic > 0.05
    assert e.work == pytest.approx(e.elastic, rel=1e-4)
    tip = model.x[-1, 1]
    assert e.work == pytest.approx(0.5 * force[1] * tip, rel=0.05)


def knot() -> Rods:
    """A loose overhand knot between two pinned ends."""
    points = equal_chords(read_centreline(centreline_path("overhand")), 100, 480.0).points
    model = Rods([spec(points)], contact(0.3), gravity=GRAVITY, drag=20.0)
    return begun(model, *(model.pinned(side) for side in SIDES))


def test_no_step_of_a_pulled_knot_makes_energy():
    """The balance of a step closes to 1 % of its throughput: works are taken by the trapezoidal rule.

    Contacts that stick give back what they took, so friction may return a little.
    """
    model = knot()
    first, rows = model.energies.stored, []

    def go(stop):
        for _ in model.steps(StepController(0.01, 1e-6, 1.0, RADIUS), stop):
            e = model.energies
            rows.append((e.work, e.stored, e.friction, e.taken["drag"], e.algorithmic + e.error))

    go(2.0)
    way = model.x[0, :3] - model.x[-1, :3]
    pull = model.driven("start", way / np.linalg.norm(way), lambda t: 20.0 * (t - 2.0))
    model.begin(pull, model.pinned("end"))
    go(6.0)
    assert knot_type(model.centreline()).name.startswith("3_1")
    assert model.energies.friction > 0.3 * model.energies.work > 1.0
    model.begin(model.pinned("end"))
    pulled = model.energies.stored
    go(6.3)
    e = model.energies
    assert e.stored < pulled - 10.0
    work, stored, *others = np.array(rows).T
    rubbed, dragged, rest = (np.diff(sums, prepend=0.0) for sums in others)
    throughput = np.abs(np.diff(work, prepend=0.0)) + np.maximum(-np.diff(stored, prepend=first), 0.0)
    assert dragged.min() > -1e-7 * e.work
    assert rubbed.min() > -3e-4 * e.work
    assert np.all(rest > -0.01 * throughput - 1e-9)
    assert abs(e.error) < 0.01 * throughput.sum()
    taken = e.friction + e.taken["drag"] + e.algorithmic
    assert e.work == pytest.approx(e.stored - first + taken + e.error, rel=1e-9)
