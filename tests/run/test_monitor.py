"""What is tied into what, and what has come undone."""

from __future__ import annotations

import re

import numpy as np
import pytest

import knotfem as kf
from knotfem.errors import KnotLost
from knotfem.geometry.curve import interpolate
from knotfem.geometry.readers import read_centreline
from knotfem.geometry.resample import equal_chords
from knotfem.geometry.vectors import unit
from knotfem.models.build import build_model
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive
from knotfem.run.monitor import KnotMonitor, apart, of_checkpoint
from knotfem.scene import load_scene
from knotfem.shipped import centreline_path
from knotfem.topology.knot_type import knot_type

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
    assert monitor.lost(before, x) == ""
    moved = x.copy()
    moved[built.sections.of_node >= built.sections.first[1], 0] += 200.0
    assert monitor.lost(before, moved) == "hitch and bight have come apart"
    assert monitor.gone(before, moved) == ["hitch and bight have come apart"]
    assert monitor.gone(before, moved, ["hitch and bight have come apart"]) == []


@pytest.mark.parametrize(
    ("before", "now", "expected"),
    [
        (("a", "b"), ("", ""), True),
        (("a", "b"), ("c", ""), False),
        (("a", "b"), ("", "c"), False),
        (("a", ""), ("", ""), False),
    ],
)
def test_rods_are_apart_where_both_ways_of_continuing_their_ends_agree(before, now, expected):
    assert apart(before, now) == expected


def rod_model(scene, points, **changes):
    """A model of one rod, its monitor as the rod was tied, and the unknowns of the rod along other points."""
    built = build_model(load_scene(scene, {"model": "rod", "output.fields": False, **changes}))
    tied = built.straight().x

    def along(line):
        x = tied.copy()
        x[:, :3] = equal_chords(interpolate(line), len(x) - 1).points
        return x

    return KnotMonitor(built, [along(points)[:, :3]]), along


def turned_into_the_knot() -> np.ndarray:
    """An overhand knot whose last lead is bent back, so that its tangent runs through the loop."""
    drawn = 6.0 * equal_chords(read_centreline(centreline_path("overhand")), 240).points
    head = drawn[: int(0.79 * len(drawn))]
    t, away = unit(head[-1] - head[-2]), np.array([0.9, -0.4, 0.3])
    side = unit(away - (away @ t) * t)
    angle = np.linspace(0.0, np.radians(205.0), 40)[1:, None]
    return np.concatenate([head, head[-1] + 17.0 * (np.sin(angle) * t + (1.0 - np.cos(angle)) * side)])


def test_a_knot_has_the_name_of_most_closures_and_says_that_they_disagree():
    curve = turned_into_the_knot()
    monitor, along = rod_model("overhand", curve)
    x = along(curve)
    knot = monitor.knots(x)["rod"]
    assert knot_type(x[:, :3], monitor.ends[0]).name != "3_1"
    assert knot["name"] == "3_1"
    assert re.match(r"3_1 \(by \d+ of 12 closures; .* along its tangents\)", knot["said"])
    assert sum(knot["closures"].values()) == 12


def test_no_single_closure_loses_a_knot(monkeypatch):
    """Whichever one of the twelve says that nothing is tied, the knot is held; where seven do, it is lost."""
    curve = 6.0 * equal_chords(read_centreline(centreline_path("overhand")), 240).points
    monitor, along = rod_model("overhand", curve)
    x = along(curve)
    before = monitor.knots(x)
    ways = monitor._ways(0)
    untied: list[int] = []
    straight = np.linspace([0.0, 0.0, 0.0], [480.0, 0.0, 0.0], 100)

    def typed(points, way):
        return knot_type(straight if any(way is ways[i] for i in untied) else points)

    monkeypatch.setattr(monitor, "_ways", lambda rod: ways)
    monkeypatch.setattr("knotfem.topology.closures.knot_type", typed)
    for untied[:] in ([i] for i in range(12)):
        assert monitor.lost(before, x) == ""
    untied[:] = range(1, 7)
    assert monitor.lost(before, x) == ""
    untied[:] = range(7)
    assert monitor.lost(before, x) == "the 3_1 of rod has come undone"


def coil(turns: float, back: float = 0.0) -> np.ndarray:
    """A rod wound about the axis of y, and then back."""
    there = np.linspace(0.0, 2.0 * np.pi * turns, 200)
    angle = np.concatenate([there, there[-1] - np.linspace(0.0, 2.0 * np.pi * back, 100)[1:]]) if back else there
    return np.stack([13.0 * np.cos(angle), np.linspace(0.0, 40.0, len(angle)), 13.0 * np.sin(angle)], axis=1)


@pytest.mark.parametrize(
    ("before", "now", "said"),
    [
        ((2.0,), (0.3,), "it has left cylinder"),
        ((2.0,), (1.0,), ""),
        ((0.55,), (0.45,), ""),
        ((1.2, 1.2), (0.4, 0.4), "it has left cylinder"),
        ((0.3,), (0.1,), ""),
    ],
)
def test_a_hitch_is_lost_when_it_has_left_its_obstacle(before, now, said):
    monitor, along = rod_model("clove-hitch", coil(*before))
    knots = monitor.knots(along(coil(*before)))
    assert knots["rod"]["said"].startswith("unknot" if before == (0.3,) else "hitch round cylinder (")
    assert knots["rod"]["turns"][0] == pytest.approx(before[0], abs=0.03)
    assert knots["rod"]["name"] == "unknot"
    now_x = along(coil(*now))
    found = monitor.lost(knots, now_x)
    assert found == (f"the hitch of rod has come undone: {said}" if said else "")
    assert monitor.gone(knots, now_x) == (["rod has left cylinder"] if said else [])


def test_knots_of_older_checkpoints_are_read():
    assert of_checkpoint(None) is None
    read = of_checkpoint({"rod": {"name": "unknot", "linking": (-2,), "laced": {}}})
    assert read == {"rod": {"name": "unknot", "said": "unknot", "linking": (-2,), "turns": (2.0,), "laced": {}}}


def test_a_slippery_sheet_bend_ends_the_run(tmp_path):
    quick = (
        "steps.1.displacement=3 mm", "rods.0.mesh.element_length=4 mm", "rods.1.mesh.element_length=4 mm",
        "quasi_static.settling_slip_over_diameter=0.1",
    )  # fmt: skip
    scene = load_scene("sheet-bend", ["model=rod", "contact.friction=0.1", *quick, *COARSE])
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(KnotLost, match="hitch and bight have come apart"):
        drive(run, "pull")
    assert (run.read_status()["state"], run.read_status()["exit_code"]) == ("failed", KnotLost.exit_code)
    assert set(run.read_summary()["knot_before"]["hitch"]["laced"]) == {"bight"}
    assert np.isfinite(run.read_summary()["final_force_N"])


def test_what_happens_in_a_step_that_need_not_hold_is_said_once(tmp_path, monkeypatch):
    """In which step and where; kept in the summary, said at the end, and not lost with the process."""
    asked = iter(range(1000))

    def gone(monitor, before, x, told):
        return ["rod has left cylinder"] if next(asked) > 1 else []

    monkeypatch.setattr(KnotMonitor, "gone", gone)
    pull = {
        "kind": "pull",
        "displacement": "5 mm",
        "ends": {"rod": {"start": {"motion": "driven", "direction": [0, 0, 1]}}},
    }
    changes = {
        "model": "rod",
        "output.fields": False,
        "rods.0.mesh.element_length": "4 mm",
        "output.every_displacement": "1 mm",
    }
    for must_hold in (False, True):
        steps = [{"kind": "relax"}, {**pull, "must_hold": must_hold}]
        run = kf.pull("clove-hitch", {**changes, "steps": steps}, out=tmp_path / f"{must_hold}", progress=False)
        if must_hold:
            assert run.summary["remarks"] == []
            continue
        (remark,) = run.summary["remarks"]
        assert remark["said"] == f"pull: rod has left cylinder at {remark['displacement_mm']:.4g} mm"
        assert 0.0 < remark["displacement_mm"] < 5.0
        assert remark["said"] in run.notes
        assert run.summary["knot_before"].startswith("hitch round cylinder (2.")


@pytest.mark.slow
def test_a_hitch_that_unwinds_off_its_cylinder_is_said_to_have_left_it(tmp_path):
    """A clove hitch whose end is let go unwinds off its cylinder: in which step, and where, once."""
    up = {"motion": "driven", "direction": [0, 0, 1]}
    tighten = {"kind": "pull", "name": "tighten", "displacement": "5 mm", "ends": {"rod": {"start": up}}}
    ends = {"rod": {"start": up, "end": {"motion": "free"}}}
    let_go = {"kind": "pull", "name": "let-go", "displacement": "3 mm", "must_hold": False, "ends": ends}
    rubbing = {"contact.friction": 0.02, "obstacles.0.friction": 0.02, "rods.0.mesh.element_length": "4 mm"}
    steps = [{"kind": "relax"}, tighten, let_go]
    changes = {"model": "rod", "output.fields": False, "steps": steps, **rubbing}
    run = kf.pull("clove-hitch", changes, out=tmp_path / "run", progress=False)
    assert run.summary["knot_before"].startswith("hitch round cylinder (2.")
    assert run.summary["knot_after"] == "unknot"
    (remark,) = run.summary["remarks"]
    assert remark["step"] == "let-go"
    assert remark["said"] == f"let-go: rod has left cylinder at {remark['displacement_mm']:.4g} mm"
    assert 5.0 <= remark["displacement_mm"] <= 8.0
    assert remark["said"] in run.notes
