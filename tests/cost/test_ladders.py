"""Ladders are scenes, fall in size, and differ from the scene in what they say."""

import itertools
import re

import pytest

from knotfem.errors import InputError
from knotfem.run.check import UNUSED
from knotfem.scene import load_scene
from knotfem.study.ladders import LADDERS, SIZED, base_rung, make_ladders, refines


@pytest.mark.parametrize(
    ("name", "overrides"),
    [("bowline", []), ("overhand", ["model=rod"]), ("cantilever", []), ("capstan", []), ("sheet-bend", [])],
)
def test_every_rung_is_a_scene_of_its_own(name, overrides):
    base = load_scene(name, overrides)
    rungs = [rung for rungs in make_ladders(base).values() for rung in rungs]
    assert len({rung.name for rung in rungs}) == len(rungs)
    scenes = [load_scene(name, [*overrides, *rung.overrides]) for rung in rungs]
    for one, other in itertools.combinations([base, *scenes], 2):
        assert one != other


def test_sizes_fall_and_pass_through_the_scene():
    for name, rungs in make_ladders(load_scene("bowline")).items():
        if name in SIZED:
            sizes = [rung.size for rung in rungs]
            assert sizes == sorted(sizes, reverse=True)
            assert max(sizes) > base_rung().size > min(sizes)


def test_scene_has_the_ladders_of_what_it_computes():
    assert set(make_ladders(load_scene("bowline"))) == set(LADDERS)
    free = set(make_ladders(load_scene("cantilever")))
    assert not free & {"penalty", "sampling", "stick"}
    assert {"section", "slice", "step", "tolerance", "uniform"} <= free
    slippery = make_ladders(load_scene("overhand", ["contact.friction=0.0"]))
    assert "stick" not in slippery
    assert "penalty" in slippery


def test_rod_ladders_change_only_what_rods_read():
    ladders = make_ladders(load_scene("overhand", ["model=rod"]))
    assert not set(ladders) & {"section", "element", "penalty", "stick"}
    own = [
        override for name, rungs in ladders.items() if name != "model" for rung in rungs for override in rung.overrides
    ]
    keys = {re.sub(r"\.\d+", "", override.partition("=")[0]) for override in own}
    assert keys
    assert not keys & set(UNUSED["rod"])


def test_uniform_scales_everything():
    base = load_scene("sheet-bend")
    (rung,) = [rung for rung in make_ladders(base)["uniform"] if rung.name == "uniform-48"]
    fine = load_scene("sheet-bend", rung.overrides)
    assert rung.size == 0.5
    assert [rod.mesh.section_elements for rod in fine.rods] == [48, 48]
    assert [rod.mesh.element_length for rod in fine.rods] == [1.0, 1.0]
    assert fine.solver.move_over_diameter == 0.25
    assert fine.solver.force_tolerance == pytest.approx(0.25e-5)
    assert fine.contact.stiffness_over_modulus == 96.0
    assert fine.contact.stick_over_diameter == pytest.approx(1.0 / 120.0)


def test_rungs_refine_what_they_are_finer_than():
    base = load_scene("overhand")
    ladders = make_ladders(base)

    def scene(ladder, size):
        (rung,) = [rung for rung in ladders[ladder] if rung.size == size]
        return load_scene("overhand", rung.overrides)

    assert refines(base, base)
    assert refines(scene("slice", 0.5), base)
    assert refines(base, scene("penalty", 2.0))
    assert refines(scene("uniform", 0.5), scene("slice", 2.0))
    assert not refines(base, scene("step", 0.125))
    assert not refines(scene("slice", 0.5), scene("section", 0.5))
    assert not refines(load_scene("overhand", ["rods.0.mesh.element=hex8"]), base)
    assert not refines(load_scene("overhand", ["model=rod"]), base)


def test_ladders_by_name():
    bowline = load_scene("bowline")
    assert set(make_ladders(bowline, ["slice", "step"])) == {"slice", "step"}
    with pytest.raises(InputError, match='found "slices"; expected "slice"'):
        make_ladders(bowline, ["slices"])
    with pytest.raises(InputError, match="no such ladder"):
        make_ladders(load_scene("cantilever"), ["penalty"])
