"""The energy account: nothing comes from nothing, friction only takes."""

import numpy as np
import pytest
from reduced import RADIUS, contact, line, spec, still

from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.models.rod.ends import End, clamped, driven, pinned
from knotfem.models.rod.model import RodModel
from knotfem.shipped import centreline_path
from knotfem.solver.schemes import hht
from knotfem.solver.stepping.integrator import StepControl
from knotfem.topology.knot_type import knot_type

GRAVITY = np.array([0.0, 0.0, -9810.0])


def test_a_free_swing_keeps_its_energy():
    model = RodModel([spec(line(12, 60.0))], gravity=GRAVITY, scheme=hht(0.0))
    model.begin({(0, "start"): clamped(model.end_frame(0, "start"))})
    scale, worst = 0.0, 0.0
    for _ in model.march(StepControl(5e-4, 1e-6, 5e-4, 1e3), model.settings(1e-8), [0.05]):
        e = model.ledger.energies
        scale, worst = max(scale, e.kinetic), max(worst, abs(e.numerical))
    assert scale > 0.01
    assert worst < 2e-3 * scale


def test_work_of_a_driven_end_is_stored():
    model = still(line(20, 60.0))
    force = np.array([0.0, 0.02, 0.0])
    ends = {(0, "start"): clamped(model.end_frame(0, "start")), (0, "end"): End(force=lambda t: t * force)}
    model.begin(ends)
    for _ in model.march(StepControl(0.05, 1e-3, 0.05, 1e3), model.settings(1e-9), [1.0]):
        pass
    e = model.ledger.energies
    assert e.elastic > 0.05
    assert e.work == pytest.approx(e.elastic, rel=1e-4)
    tip = model.x[-1, 1]
    assert e.work == pytest.approx(0.5 * force[1] * tip, rel=0.05)


def knot() -> RodModel:
    """A loose overhand knot between two pinned ends."""
    points = equal_chords(read_centreline(centreline_path("overhand")), 100, 480.0).points
    model = RodModel([spec(points)], contact(0.3), gravity=GRAVITY, drag=20.0)
    model.begin({(0, side): pinned(model.end_frame(0, side)) for side in ("start", "end")})
    return model


def test_no_step_of_a_pulled_knot_makes_energy():
    """The account of a step closes to 1 % of what it turns over: works are taken by the trapezoidal rule."""
    model = knot()
    control, settings = StepControl(0.01, 1e-6, 1.0, RADIUS), model.settings()
    e = model.ledger.energies
    first, rows = e.stored, []

    def march(stop):
        for _ in model.march(control, settings, [stop]):
            ledger = model.ledger
            rows.append((e.work, e.stored, ledger.friction_step, ledger.drag_step, ledger.numerical_step))

    march(2.0)
    way = model.x[0, :3] - model.x[-1, :3]
    pull = driven(model.end_frame(0, "start"), way / np.linalg.norm(way), lambda t: 20.0 * (t - 2.0))
    model.begin({(0, "start"): pull, (0, "end"): pinned(model.end_frame(0, "end"))})
    march(6.0)
    assert knot_type(model.centreline()).name.startswith("3_1")
    assert e.friction > 0.3 * e.work > 1.0
    model.begin({(0, "end"): pinned(model.end_frame(0, "end"))})
    pulled = e.stored
    march(6.3)
    assert e.stored < pulled - 10.0
    work, stored, rubbed, dragged, rest = np.array(rows).T
    turned_over = np.abs(np.diff(work, prepend=0.0)) + np.maximum(-np.diff(stored, prepend=first), 0.0)
    assert min(rubbed.min(), dragged.min()) > -1e-7 * e.work
    assert np.all(rest > -0.01 * turned_over - 1e-9)
    assert e.work == pytest.approx(e.stored - first + e.friction + e.drag + e.numerical, rel=1e-9)
