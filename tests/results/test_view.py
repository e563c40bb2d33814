"""From where a knot is seen."""

from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner
from coarse import HITCH, KNOT

import knotfem as kf
from knotfem.results import pictures
from knotfem.results.states import RunState
from knotfem.results.view import camera_for, knot_points
from knotfem.scene.model import Scene
from knotfem_cli.main import knotfem_command

TIED = {"output.fields": True, "tie.path": "direct", "solver.threads": 1}


@cache
def hitch() -> RunState:
    return kf.tie("clove-hitch", {**HITCH, **TIED}, progress=False).states[-1]


@cache
def knot() -> RunState:
    return kf.tie("overhand", {**KNOT, **TIED}, progress=False).states[-1]


def seen(state: RunState) -> tuple[Scene, list[np.ndarray]]:
    fields = state.fields
    return state.scene, [
        fields.points[rings].mean(axis=1) for rings in pictures._look(fields, state.scene, "none").rings
    ]


def test_a_hitch_is_seen_from_the_side_of_its_crossings():
    scene, lines = seen(hitch())
    direction = np.asarray(camera_for(scene, lines).direction)
    direction /= np.linalg.norm(direction)
    assert abs(direction @ scene.obstacles[0].axis) < 0.35
    assert direction[0] < -0.9, "its crossings are where x is largest"


def test_another_knot_is_seen_from_y():
    assert camera_for(*seen(knot())).direction == (0.25, 1.0, -0.12)


def test_a_view_that_is_asked_for_has_z_or_y_upwards():
    scene, lines = seen(hitch())
    side, above = camera_for(scene, lines, (2.0, -1.0, 0.5)), camera_for(scene, lines, (0.0, 0.0, 3.0))
    np.testing.assert_array_equal(side.direction, (-2.0, 1.0, -0.5))
    assert (side.up, above.up) == ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    for wrong in ((0.0, 0.0, 0.0), (1.0, 2.0), (1.0, 2.0, float("inf"))):
        with pytest.raises(kf.InputError, match="view: no direction"):
            camera_for(scene, lines, wrong)


def test_the_verb_takes_a_view(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(RunState, "render", lambda state, *arguments, **options: asked.append(options["view"]))
    kf.tie("overhand", {**KNOT, **TIED}, out=tmp_path / "run", progress=False)
    call = ["render", str(tmp_path / "run"), "-o", str(tmp_path / "a.png")]
    for options in ([], ["--view", "1,-2,0.5"]):
        assert CliRunner().invoke(knotfem_command, [*call, *options]).exit_code == 0
    assert asked == [None, (1.0, -2.0, 0.5)]
    assert CliRunner().invoke(knotfem_command, [*call, "--view", "up"]).exit_code == 3


def test_a_hitch_is_shown_with_its_turns_about_the_cylinder():
    points = knot_points(*seen(hitch()))
    turned = np.sort(np.arctan2(points[:, 2], points[:, 0]))
    assert np.diff(turned, append=turned[0] + 2.0 * np.pi).max() < 0.5
