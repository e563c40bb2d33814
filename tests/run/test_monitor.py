"""What is tied into what, and what has come undone."""

from __future__ import annotations

import numpy as np
import pytest

from knotfem.errors import KnotLost
from knotfem.models.build import build_model
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive
from knotfem.run.monitor import KnotMonitor
from knotfem.scene import load_scene

COARSE = ("rods.0.mesh.section_elements=4", "rods.1.mesh.section_elements=4", "output.fields=false")


@pytest.mark.parametrize("model", ["fem", "rod"])
def test_rods_that_come_apart_are_lost(model):
    built = build_model(load_scene("sheet-bend", [f"model={model}", *COARSE]))
    monitor = KnotMonitor(built)
    x = list(built.mapping(built.paths(), "auto"))[-1].state.x
    before = monitor.knots(x)
    assert before["hitch"]["name"] == before["bight"]["name"] == "unknot"
    assert before["hitch"]["laced"] == {"bight": before["bight"]["laced"]["hitch"]}
    assert all(before["hitch"]["laced"]["bight"])
    assert monitor.lost(before, before) == ""
    apart = x.copy()
    apart[built.sections.of_node >= built.sections.first[1], 0] += 200.0
    assert monitor.lost(before, monitor.knots(apart)) == "hitch and bight have come apart"


@pytest.mark.parametrize(
    ("before", "now", "apart"),
    [
        (("a", "b"), ("", ""), True),
        (("a", "b"), ("c", ""), False),
        (("a", "b"), ("", "c"), False),
        (("a", ""), ("", ""), False),
    ],
)
def test_rods_are_apart_where_both_ways_of_continuing_their_ends_agree(before, now, apart):
    rod = {"name": "unknot", "linking": []}
    states = [{"a": {**rod, "laced": {"b": links}}, "b": {**rod, "laced": {"a": links}}} for links in (before, now)]
    assert (KnotMonitor.lost(*states) == "a and b have come apart") == apart


@pytest.mark.parametrize(
    ("before", "now", "said"),
    [
        ({"name": "3_1", "linking": [0]}, {"name": "unknot", "linking": [0]}, "the 3_1 of rod has come undone"),
        ({"name": "unknot", "linking": [1]}, {"name": "unknot", "linking": [0]}, "the hitch of rod has come undone"),
        ({"name": "3_1", "linking": [0]}, {"name": "4_1", "linking": [0]}, ""),
        ({"name": "unknot", "linking": [0]}, {"name": "unknot", "linking": [0]}, ""),
    ],
)
def test_what_is_said_of_one_rod(before, now, said):
    states = [{"rod": {**knot, "laced": {}}} for knot in (before, now)]
    assert KnotMonitor.lost(*states) == said


def test_a_slippery_sheet_bend_ends_the_run(tmp_path):
    quick = ("steps.1.displacement=3 mm", "rods.0.mesh.element_length=4 mm", "rods.1.mesh.element_length=4 mm")
    scene = load_scene("sheet-bend", ["model=rod", "contact.friction=0.1", *quick, *COARSE])
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(KnotLost, match="hitch and bight have come apart"):
        drive(run, "pull")
    assert (run.read_status()["state"], run.read_status()["exit_code"]) == ("failed", KnotLost.exit_code)
    assert set(run.read_summary()["knot_before"]["hitch"]["laced"]) == {"bight"}
    assert np.isfinite(run.read_summary()["final_force_N"])
