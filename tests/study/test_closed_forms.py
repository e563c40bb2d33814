"""Closed forms against published figures, and the scenes that have one."""

import numpy as np
import pytest

from knotfem.scene import load_scene
from knotfem.study.closed_forms import closed_form, heavy_cantilever


@pytest.mark.parametrize(("load", "sag"), [(1.0, 0.12347), (5.0, 0.49591), (10.0, 0.70020)])
def test_heavy_cantilever(load, sag):
    assert heavy_cantilever(load) == pytest.approx(sag, abs=1e-5)


def test_heavy_cantilever_of_little_weight_is_the_linear_beam():
    assert heavy_cantilever(1e-3) == pytest.approx(1e-3 / 8.0, rel=1e-4)


def test_scenes_with_a_closed_form():
    cantilever = closed_form(load_scene("cantilever"))
    assert cantilever is not None
    load = 1.16e-9 * 9810.0 * np.pi * 9.0 * 80.0**3 / (1.425 * np.pi * 81.0 / 4.0)
    assert (cantilever.quantity, cantilever.value) == ("sag", pytest.approx(80.0 * heavy_cantilever(load)))
    assert 0.01 < cantilever.bound < 0.05
    light, capstan = closed_form(load_scene("cantilever", ["model=rod"])), closed_form(load_scene("capstan"))
    assert light is not None
    assert light.bound < 1e-3
    assert capstan is not None
    assert (capstan.quantity, capstan.value) == ("force_end", pytest.approx(3.0 * 2.187, rel=1e-3))


@pytest.mark.parametrize(
    ("scene", "overrides"),
    [
        ("overhand", []),
        ("bowline", []),
        ("cantilever", ["gravity=none"]),
        ("cantilever", ["gravity.direction=[1, 0, 0]"]),
        ("cantilever", ['steps.0.ends.rod.end={ motion = "pinned" }']),
        ("capstan", ['steps.2.ends.rod.end.force="1 N"']),
        ("capstan", ['steps.2.ends.rod.end={ motion = "clamped" }']),
    ],
)
def test_scenes_without(scene, overrides):
    assert closed_form(load_scene(scene, overrides)) is None
