"""What the signs say."""

import math

import numpy as np
import pytest

from knotfem.scene import load_scene
from knotfem.scene.effects import Cylinder
from knotfem.stability import ties
from knotfem.stability.ends import deciding_steps, free_ends, loaded_ends
from knotfem.stability.ties import TieReader, restored, stored
from knotfem.stability.verdict import Signs, in_words, verdict_of

SIGNS = {"lost": "", "at_rest": False, "through": 0.0, "rate": math.nan, "diameter": 6.0}


@pytest.mark.parametrize(
    ("signs", "verdict"),
    [
        ({"lost": "the 3_1 of rod has come undone", "at_rest": True}, "unravels"),
        ({"at_rest": True, "through": 50.0}, "holds"),
        ({"through": 7.0}, "slips"),
        ({"through": 5.0}, "undecided"),
        ({"through": 50.0, "rate": 0.02}, "holds"),
        ({"through": 50.0, "rate": 0.5}, "undecided"),
        ({"through": 50.0, "rate": 0.97}, "slips"),
    ],
)
def test_verdicts(signs, verdict):
    found = Signs(**{**SIGNS, **signs})
    assert verdict_of(found) == verdict
    assert in_words(verdict, found, "none").startswith(("the knot " + verdict, verdict))


def test_the_failure_mode_is_told():
    found = Signs(**{**SIGNS, "lost": "the 3_1 of rod has come undone"})
    assert in_words("unravels", found, "central").endswith("; the central strands slipped first")


def test_ends_that_are_loaded_and_free():
    scene = load_scene("bowline-lowered")
    assert [loaded_ends(step) for step in scene.steps] == [[], *[[("rod", "start")]] * 4]
    assert [free_ends(step) for step in scene.steps] == [[], [], [], *[[("rod", "end")]] * 2]
    assert [step.name for step in deciding_steps(scene.steps)] == ["let-go", "lower"]
    assert deciding_steps(load_scene("overhand").steps) == []
    assert free_ends(load_scene("sheet-bend").steps[-1]) == [("hitch", "end"), ("bight", "end")]
    assert free_ends(load_scene("capstan").steps[-1]) == [("rod", "end")]


def trefoil(open_at: float) -> np.ndarray:
    """An overhand knot whose last end is cut off at this fraction of a closed trefoil."""
    t = np.linspace(0.0, 2.0 * np.pi * open_at, 150) - 0.7
    return 20.0 * np.stack(
        [np.sin(t) + 2.0 * np.sin(2.0 * t), np.cos(t) - 2.0 * np.cos(2.0 * t), -1.5 * np.sin(3.0 * t)], axis=1
    )


def reader(points: np.ndarray, obstacles=()) -> TieReader:
    away = tuple(points[i] - points.mean(axis=0) for i in (0, -1))
    out = (points[0] - points[1], points[-1] - points[-2])
    return TieReader(["rod"], [(out, away)], obstacles)


def test_a_rod_that_is_drawn_out_of_its_knot_has_come_undone():
    tied = trefoil(0.93)
    read = reader(tied)
    before = read.read([tied])
    assert before[0].knotted
    assert read.undone(before, [tied]) == ""
    assert read.undone(before, [trefoil(0.5)]) == "the 3_1 of rod has come undone"
    assert restored(stored(before)) == before


def test_the_first_closure_that_is_as_it_was_decides(monkeypatch):
    tied = trefoil(0.93)
    read = reader(tied)
    before = read.read([tied])
    asked, named = [], ties.knot_type
    monkeypatch.setattr(ties, "knot_type", lambda line, ends: asked.append(ends) or named(line, ends))
    assert read.undone(before, [tied]) == ""
    assert len(asked) == 1
    assert read.undone(before, [trefoil(0.5)])
    assert len(asked) == 4


def test_an_end_that_only_swings_undoes_nothing():
    """Its continuation along the rod sweeps over the knot."""
    tied = trefoil(0.93)
    read = reader(tied)
    before = read.read([tied])
    turned = tied.copy()
    inward = tied[:-1].mean(axis=0) - tied[-1]
    turned[-1] = tied[-2] + 0.5 * inward / np.linalg.norm(inward)
    assert read.undone(before, [turned]) == ""


def test_a_hitch_comes_undone_when_it_unwinds():
    cylinder = Cylinder.model_validate({"diameter": "20 mm", "axis": [0, 0, 1], "friction": 0.3})

    def coil(turns: float) -> np.ndarray:
        angle = np.linspace(0.0, 2.0 * np.pi * turns, 100)
        return np.stack([13.0 * np.cos(angle), 13.0 * np.sin(angle), 2.0 * angle], axis=1)

    read = reader(coil(2.0), (cylinder,))
    before = read.read([coil(2.0)])
    assert before[0].linking == (2,)
    assert read.undone(before, [coil(1.6)]) == ""
    assert read.undone(before, [coil(1.3)]) == "the hitch of rod has come undone"
