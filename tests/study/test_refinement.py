"""Refinement series are scenes, fall in size, and differ from the scene in what they say."""

import itertools
import re

import pytest

from knotfem.errors import InputError
from knotfem.run.check import UNUSED
from knotfem.scene import load_scene
from knotfem.study.refinement import SERIES, SIZED, base_level, make_series, refines


@pytest.mark.parametrize(
    ("name", "overrides"),
    [("bowline", []), ("overhand", ["model=rod"]), ("cantilever", []), ("capstan", []), ("sheet-bend", [])],
)
def test_every_level_is_a_scene_of_its_own(name, overrides):
    base = load_scene(name, overrides)
    levels = [level for levels in make_series(base).values() for level in levels]
    assert len({level.name for level in levels}) == len(levels)
    scenes = [load_scene(name, [*overrides, *level.overrides]) for level in levels]
    for one, other in itertools.combinations([base, *scenes], 2):
        assert one != other


def test_sizes_fall_and_pass_through_the_scene():
    for name, levels in make_series(load_scene("bowline")).items():
        if name in SIZED:
            sizes, own = [level.size for level in levels if level.size is not None], base_level().size
            assert len(sizes) == len(levels)
            assert sizes == sorted(sizes, reverse=True)
            assert own is not None
            assert max(sizes) > own > min(sizes)


def test_scene_has_the_series_of_what_it_computes():
    assert set(make_series(load_scene("bowline"))) == set(SERIES)
    free = set(make_series(load_scene("cantilever")))
    assert not free & {"penalty", "ramp", "sampling", "stick"}
    assert {"section", "slice", "step", "tolerance", "uniform"} <= free
    slippery = make_series(load_scene("overhand", ["contact.friction=0.0"]))
    assert "stick" not in slippery
    assert "penalty" in slippery


def test_rod_series_change_only_what_rods_read():
    series = make_series(load_scene("overhand", ["model=rod"]))
    assert not set(series) & {"section", "element"}
    own = [
        override
        for name, levels in series.items()
        if name != "model"
        for level in levels
        for override in level.overrides
    ]
    keys = {re.sub(r"\.\d+", "", override.partition("=")[0]) for override in own}
    assert keys
    assert not keys & set(UNUSED["rod"])


def test_uniform_scales_everything():
    base = load_scene("sheet-bend")
    (level,) = [level for level in make_series(base)["uniform"] if level.name == "uniform-48"]
    fine = load_scene("sheet-bend", level.overrides)
    assert level.size == 0.5
    assert [rod.mesh.section_elements for rod in fine.rods] == [48, 48]
    assert [rod.mesh.element_length for rod in fine.rods] == [1.0, 1.0]
    assert fine.solver.move_over_diameter == 0.25
    assert fine.solver.force_tolerance == pytest.approx(0.25e-5)
    assert fine.contact.stiffness_over_modulus == 96.0
    assert fine.contact.stick_over_diameter == pytest.approx(0.0025)


def test_levels_refine_what_they_are_finer_than():
    base = load_scene("overhand")
    series = make_series(base)

    def scene(name, size):
        (level,) = [level for level in series[name] if level.size == size]
        return load_scene("overhand", level.overrides)

    assert refines(base, base)
    assert refines(scene("slice", 0.5), base)
    assert refines(base, scene("penalty", 2.0))
    assert refines(scene("uniform", 0.5), scene("slice", 2.0))
    assert not refines(base, scene("step", 0.125))
    assert not refines(scene("slice", 0.5), scene("section", 0.5))
    assert not refines(load_scene("overhand", ["rods.0.mesh.element=hex8"]), base)
    assert not refines(load_scene("overhand", ["model=rod"]), base)


def test_series_by_name():
    bowline = load_scene("bowline")
    assert set(make_series(bowline, ["slice", "step"])) == {"slice", "step"}
    with pytest.raises(InputError, match='found "slices"; expected "slice"'):
        make_series(bowline, ["slices"])
    with pytest.raises(InputError, match="no such refinement series"):
        make_series(load_scene("cantilever"), ["penalty"])
