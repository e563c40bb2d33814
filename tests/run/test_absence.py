"""What a scene does not call for is neither imported nor made nor visited, and is listed with why."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from knotfem.contact import tube_contact as contact_module
from knotfem.errors import InputError
from knotfem.models.registry import REGISTRY
from knotfem.models.solid.assembly import Model, build_model, step_system
from knotfem.models.solid.body import build_body
from knotfem.run import driver
from knotfem.run.check import check
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene, scene_to_toml

SMALL = (
    "rods.0.length=40 mm", "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=4 mm", "tie.increments=1",
    "output.fields=false", "solver.threads=1",
)  # fmt: skip
BARE = (*SMALL, "rods.0.core=none", "gravity=none", "drag=none")
"""Of the scene "cantilever": nothing but elasticity."""
ON = {
    "core": ("rods.0.core={youngs_modulus='75.5 GPa', radius='0.127 mm'}",),
    "inertia": ("inertia.scheme=backward-euler",),
    "drag": ("drag.rate=10 1/s",),
    "gravity": ("gravity.acceleration=9.81 m/s^2",),
    "viscous_drag": ("effects.viscous_drag={normal='2 Pa s', tangential='1 Pa s'}",),
    "contact": ("contact.enabled=true", "contact.friction=0"),
    "friction": ("contact.enabled=true", "contact.friction=0.3"),
    "cylinder": (
        "contact.enabled=true", "contact.friction=0",
        "obstacles=[{diameter='9 mm', axis=[0,1,0], point=['0 mm','0 mm','-9 mm'], friction=0.0}]",
    ),
    "cylinder friction": (
        "contact.enabled=true", "contact.friction=0",
        "obstacles=[{diameter='9 mm', axis=[0,1,0], point=['0 mm','0 mm','-9 mm'], friction=0.4}]",
    ),
}  # fmt: skip
"""Overrides of the bare scene that call for an effect."""
ZERO = {
    "drag": ("drag.rate=0 1/s",),
    "gravity": ("gravity.acceleration=0 m/s^2",),
    "viscous_drag": ("effects.viscous_drag={normal='0 Pa s', tangential='0 Pa s'}",),
}
"""Overrides that have its table with nothing in it."""


def model_of(*overrides: str) -> Model:
    return build_model(build_body(load_scene("cantilever", [*BARE, *overrides])))


def held(thing: object, seen: set[int]) -> Iterator[np.ndarray]:
    """All arrays that can be reached from an object of the numerics."""
    if id(thing) in seen:
        return
    seen.add(id(thing))
    if isinstance(thing, np.ndarray):
        yield thing if thing.base is None or not isinstance(thing.base, np.ndarray) else thing.base
    elif isinstance(thing, dict):
        for value in thing.values():
            yield from held(value, seen)
    elif isinstance(thing, list | tuple):
        for value in thing:
            yield from held(value, seen)
    elif type(thing).__module__.startswith("knotfem."):
        yield from held(vars(thing), seen)


def held_bytes(thing: object) -> int:
    return sum(a.nbytes for a in {id(a): a for a in held(thing, set())}.values())


@pytest.mark.parametrize("name", [registered.name for registered in REGISTRY])
def test_absent_effects_are_listed_with_why(name: str) -> None:
    reason = check(load_scene("cantilever", BARE))["absent"][name]
    assert len(reason) > 8


@pytest.mark.parametrize("name", list(ON))
def test_a_scene_turns_each_effect_on_by_itself(name: str) -> None:
    bare, model = model_of(), model_of(*ON[name])
    assert name in bare.absent
    assert name not in model.absent
    assert model.named(name)
    assert set(model.absent) | {effect.name for effect in model.effects} >= {registered.name for registered in REGISTRY}
    shown = check(load_scene("cantilever", [*BARE, *ON[name]]))
    assert name in shown["effects"]
    assert shown["system"] == ("unsymmetric (" + name + ")" if "friction" in name else "symmetric")


@pytest.mark.parametrize("name", list(ZERO))
def test_a_table_with_nothing_in_it_is_absence(name: str) -> None:
    model = model_of(*ZERO[name])
    assert "0" in model.absent[name]
    assert [effect.name for effect in model.effects] == ["elasticity"]


@pytest.mark.parametrize("name", list(ON))
def test_absence_holds_no_memory(name: str) -> None:
    """Both ways: an effect that runs holds arrays of its own, but for those that only share the mass."""
    bare = held_bytes(model_of())
    assert held_bytes(model_of(*ZERO.get(name, ()))) == bare
    assert held_bytes(model_of(*ON[name])) > bare


def test_mass_is_made_only_for_who_asks() -> None:
    assert "mass" not in vars(model_of().body)
    assert "mass" not in vars(model_of(*ON["contact"], *ON["viscous_drag"]).body)
    assert all("mass" in vars(model_of(*ON[name]).body) for name in ("inertia", "drag", "gravity"))


IMPORTS = """
from pathlib import Path
import json, sys
from knotfem.run import driver
from knotfem.run.directory import RunDirectory
from knotfem.scene import load_scene
scene = load_scene("cantilever", json.loads(sys.argv[1]))
driver.pull(scene, RunDirectory.create(scene, Path(sys.argv[2])))
print(json.dumps(sorted(name for name in sys.modules if name.startswith("knotfem."))))
"""


def imported(path: str, *overrides: str) -> set[str]:
    """Modules that a whole run needs, in a process of its own."""
    arguments = [sys.executable, "-c", IMPORTS, json.dumps([*BARE, "steps.0.duration=0.1 s", *overrides]), path]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_a_whole_run_imports_no_absent_effect(tmp_path) -> None:
    found = imported(str(tmp_path / "bare"))
    assert "knotfem.models.solid.elasticity" in found
    effects = {registered.module for registered in REGISTRY}
    assert not found & effects
    assert not {name for name in found if name.startswith("knotfem.contact.tube_contact")}
    assert not found & {"knotfem.contact.tube", "knotfem.contact.tube_search", "knotfem.contact.penalty"}


def test_a_run_visits_each_effect_that_is_there_and_no_other(tmp_path) -> None:
    scene = load_scene("cantilever", [*BARE, "steps.0.duration=0.1 s", *ON["viscous_drag"], *ON["gravity"]])
    run = RunDirectory.create(scene, tmp_path / "run")
    driver.pull(scene, run)
    summary = run.read_summary()
    assert set(summary["effects"]) == {"elasticity", "gravity", "viscous_drag"}
    assert set(summary["absent_effects"]) == {registered.name for registered in REGISTRY} - set(summary["effects"])
    table = read_table(run.path / "force.csv")
    taken = table["viscous_drag_Nmm"][-1]
    assert taken > 0.0
    assert abs(table["missing_Nmm"][-1]) < 0.05 * taken


def test_costs_of_effects_and_solver_add_up(tmp_path) -> None:
    scene = load_scene("cantilever", [*SMALL, "steps.0.duration=1 s"])
    run = RunDirectory.create(scene, tmp_path / "run")
    driver.pull(scene, run)
    summary = run.read_summary()
    total = sum(phase["cpu_s"] for phase in summary["phases"].values())
    effects = summary["effects"]
    booked = sum(effect["cpu_s"] for effect in effects.values()) + sum(summary["solver_cpu_s"].values())
    assert booked + summary["costs"]["output"]["cpu_s"] + summary["other_cpu_s"] == pytest.approx(total, abs=1e-9)
    assert -0.01 * total < summary["other_cpu_s"] < total
    assert all(effect["share"] == pytest.approx(effect["cpu_s"] / total) for effect in effects.values())
    assert 0.5 < summary["min_jacobian"] < 1.0


def test_nothing_is_searched_while_tying_or_without_contact(tmp_path, monkeypatch) -> None:
    calls = {"search": 0}
    original = contact_module.find_pairs

    def counted(*arguments) -> int:
        calls["search"] += 1
        return original(*arguments)

    monkeypatch.setattr(contact_module, "find_pairs", counted)
    straight = load_scene("cantilever", [*BARE, "steps.0.duration=0.1 s"])
    driver.pull(straight, RunDirectory.create(straight, tmp_path / "straight"))
    mapped = load_scene("cantilever", [*BARE, *ON["friction"], "steps=[]"])
    driver.tie(mapped, RunDirectory.create(mapped, tmp_path / "mapped"))
    assert calls["search"] == 0
    touching = load_scene("cantilever", [*BARE, *ON["friction"], "steps.0.duration=0.1 s"])
    driver.pull(touching, RunDirectory.create(touching, tmp_path / "touching"))
    assert calls["search"] > 0


@pytest.mark.parametrize("name", list(ON))
def test_matrix_type_follows_from_the_effects(name: str) -> None:
    model = model_of(*ON[name])
    body = model.body
    x = np.concatenate([rod.mesh.nodes for rod in body.rods])
    system = step_system(model, body.scene.steps[0], 0.0, x, {}, 1).system
    assert system.symmetric is ("friction" not in name)


def test_a_registered_effect_has_a_table_in_the_scene(tmp_path) -> None:
    scene = load_scene("cantilever", ["effects.viscous_drag={normal='2 Pa s', tangential='1 Pa s'}"])
    path = tmp_path / "cantilever.toml"
    path.write_text(scene_to_toml(scene))
    assert load_scene(path) == scene
    for override, message in {
        "effects.viscous_drag={normal='2 Pa s'}": "effects.viscous_drag.tangential: missing key",
        "effects.viscous_drag={normal=2, tangential='1 Pa s'}": "viscous_drag.normal: a bare number",
        "effects.viscous_drag={normal='-2 Pa s', tangential='1 Pa s'}": "out of range",
        "effects.viscous_drag={norml='2 Pa s', tangential='1 Pa s'}": 'unknown key; found .*|expected "normal"',
        "effects.viscous=3": 'effects.viscous: unknown key; expected "viscous_drag"',
        "effects.viscous_drag=3": "wrong kind of value; found 3; expected a table",
    }.items():
        with pytest.raises(InputError, match=message):
            load_scene("cantilever", [override])
