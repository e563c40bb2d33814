"""Every effect that a scene calls for can be switched off by what its switch overrides."""

import pytest
from manufactured import write_run
from rich.table import Table

from knotfem.models.effects import EFFECTS
from knotfem.scene import load_scene
from knotfem.study.convergence import make_jobs
from knotfem.study.refinement import Level, base_level
from knotfem.study.switches import SWITCHES, effects_of, effects_rows, effects_table, run_effects

PAIRS = 'contact.pairs=[{between=["rod","rod"], friction=0.5}, {between=["rod","cylinder"], friction=0.2}]'


def test_every_effect_but_loads_and_what_is_no_physics_has_a_switch():
    assert {effect.name for effect in EFFECTS} - set(SWITCHES) == {"load", "numerical_drag"}


@pytest.mark.parametrize(
    ("scene", "overrides"),
    [
        ("bowline", ()),
        ("bowline", (PAIRS,)),
        ("overhand", ("steps.1.friction_schedule=[{time='0 s', friction=0.1}, {time='1 s', friction=0.3}]",)),
        ("cantilever", ()),
        ("crossed-rods", ()),
    ],
)
def test_switched_off_is_absent_and_the_rest_stays(scene, overrides):
    base = load_scene(scene, overrides)
    present = effects_of(base)
    assert present
    for name in present:
        without = load_scene(scene, [*overrides, *SWITCHES[name](base)])
        left = effects_of(without)
        assert name not in left
        gone = set(present) - set(left)
        needs = {"contact": {"friction", "cylinder", "cylinder friction"}, "cylinder": {"cylinder friction"}}
        assert gone - {name} <= needs.get(name, set())


def test_costs_and_changes(tmp_path):
    jobs = make_jobs("overhand", (), tmp_path, budget=None, tell=lambda text: None)
    base = jobs.scene_of(base_level())
    write_run(jobs.run_of(base_level()), base)
    for name in effects_of(base):
        level = Level(f"without-{name}", "effects", "", None, tuple(SWITCHES[name](base)))
        write_run(
            jobs.run_of(level),
            jobs.scene_of(level),
            state="failed" if name == "contact" else "done",
            reason="lost",
        )
    study = run_effects("overhand", (), tmp_path, budget=None, tell=lambda text: None)
    assert set(study.without) == {"core", "contact", "friction"}
    assert study.fraction("contact") == pytest.approx(0.15)
    assert study.saved("core") == pytest.approx(0.0)
    assert study.change("core", "force") == 0.0
    states = {row["effect"]: row["state"] for row in effects_rows(study)}
    assert list(states) == list(study.without)
    assert states["contact"] == "failed"
    table = effects_table(study)
    assert isinstance(table, Table)
    assert table.row_count == 3
