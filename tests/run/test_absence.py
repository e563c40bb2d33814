"""What a scene does not call for is neither imported nor made nor visited, and is listed with why."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest

import knotfem as kf
from knotfem.contact import pairs
from knotfem.errors import InputError
from knotfem.models.base import Model
from knotfem.models.build import build_model
from knotfem.models.effects import EFFECTS
from knotfem.models.rod.assembly import DiscreteRods
from knotfem.models.rod.model import RodModel
from knotfem.models.solid.model import SolidModel
from knotfem.scene import load_scene, scene_to_toml
from knotfem.solver.state import Motion, State

SMALL = (
    "rods.0.length=40 mm", "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=4 mm", "tie.increments=1",
    "output.fields=false", "solver.threads=1",
)  # fmt: skip
BARE = (
    *SMALL, "rods.0.core=none", "gravity=none", "drag=none", "inertia.scheme=quasi-static", "steps.0.rate=real",
)  # fmt: skip
"""Of the scene "cantilever": nothing but elasticity."""
ON = {
    "core": ("rods.0.core={youngs_modulus='75.5 GPa', radius='0.127 mm'}",),
    "inertia": ("inertia.scheme=backward-euler",),
    "drag": ("drag.rate=10 1/s",),
    "numerical_drag": ("steps.0.rate=quasi-static",),
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


def model_of(*overrides: str) -> SolidModel:
    model = build_model(load_scene("cantilever", [*BARE, *overrides]))
    assert isinstance(model, SolidModel)
    return model


def rods_of(*overrides: str) -> DiscreteRods:
    model = build_model(load_scene("cantilever", [*BARE, "model=rod", *overrides]))
    assert isinstance(model, RodModel)
    return model.discrete


def names_of(model: Model) -> list[str]:
    return [term.name for term in model.terms]


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


@pytest.mark.parametrize("name", [effect.name for effect in EFFECTS])
def test_absent_effects_are_listed_with_why(name: str) -> None:
    reason = kf.check("cantilever", BARE)["absent"][name]
    assert len(reason) > 8


@pytest.mark.parametrize("name", list(ON))
def test_a_scene_turns_each_effect_on_by_itself(name: str) -> None:
    bare, model = model_of(), model_of(*ON[name])
    assert name in bare.absent
    assert name not in model.absent
    assert name in names_of(model)
    assert set(model.absent) | set(names_of(model)) >= {effect.name for effect in EFFECTS}
    shown = kf.check("cantilever", [*BARE, *ON[name]])
    assert name in shown["effects"]
    assert shown["system"] == ("unsymmetric (" + name + ")" if "friction" in name else "symmetric")


@pytest.mark.parametrize("name", list(ZERO))
def test_a_table_with_nothing_in_it_is_absence(name: str) -> None:
    model = model_of(*ZERO[name])
    assert "0" in model.absent[name]
    assert names_of(model) == ["elasticity"]


@pytest.mark.parametrize("name", list(ON))
def test_absence_holds_no_memory(name: str) -> None:
    """Both ways: an effect that runs holds arrays of its own, but for those that only share the mass."""
    bare = held_bytes(model_of())
    assert held_bytes(model_of(*ZERO.get(name, ()))) == bare
    assert held_bytes(model_of(*ON[name])) > bare


def test_mass_is_made_only_for_who_asks() -> None:
    assert "mass" not in vars(model_of().body)
    assert "mass" not in vars(model_of(*ON["contact"], *ON["viscous_drag"]).body)
    assert all("mass" in vars(model_of(*ON[name]).body) for name in ("inertia", "drag", "numerical_drag", "gravity"))


def test_mass_of_discrete_rods_is_made_only_for_who_asks() -> None:
    assert "mass" not in vars(rods_of())
    assert "mass" not in vars(rods_of(*ON["contact"], *ON["viscous_drag"]))
    assert all("mass" in vars(rods_of(*ON[name])) for name in ("inertia", "drag", "numerical_drag", "gravity"))


IMPORTS = """
import json, sys
import knotfem as kf
kf.pull("cantilever", json.loads(sys.argv[1]), out=sys.argv[2])
print(json.dumps(sorted(name for name in sys.modules if name.startswith("knotfem."))))
"""
EVERYWHERE = {"knotfem.contact.report"}
"""Of the modules below what any run needs: the names of the columns of contacts.csv."""
OWN = ("knotfem.contact.", "knotfem.terms.", "knotfem.models.rod.damping")
"""Where the modules of effects are."""
NEEDED = {
    "core": {"knotfem.terms.axial"},
    "inertia": {"knotfem.terms.inertia"},
    "drag": {"knotfem.terms.inertia"},
    "numerical_drag": {"knotfem.terms.inertia"},
    "gravity": {"knotfem.terms.gravity"},
    "viscous_drag": {"knotfem.terms.viscous"},
}
"""Modules of effects that contact has no part in."""
RODS = {"knotfem.terms.axial", "knotfem.contact.material_frames"}
"""What discrete rods need besides: their stretch, and the arrays of their frames."""


def imported(path: str, *overrides: str) -> set[str]:
    """Modules of effects that a whole run needs, in a process of its own."""
    arguments = [sys.executable, "-c", IMPORTS, json.dumps([*BARE, "steps.0.duration=0.1 s", *overrides]), path]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    found = set(json.loads(done.stdout.splitlines()[-1]))
    assert any(name.startswith("knotfem.models.") for name in found)
    return {name for name in found if name.startswith(OWN)} - EVERYWHERE


@pytest.mark.parametrize(("model", "needed"), [("fem", set()), ("rod", RODS)])
def test_a_whole_run_imports_no_absent_effect(tmp_path, model: str, needed: set[str]) -> None:
    assert imported(str(tmp_path / "bare"), f"model={model}") == needed


@pytest.mark.parametrize("name", ["core", "inertia", "drag", "numerical_drag", "gravity", "viscous_drag"])
def test_a_run_imports_an_effect_that_is_there_and_no_other(tmp_path, name: str) -> None:
    assert imported(str(tmp_path / "run"), *ON[name]) == NEEDED[name]


def test_a_run_visits_each_effect_that_is_there_and_no_other(tmp_path) -> None:
    overrides = [*BARE, "steps.0.duration=0.1 s", *ON["viscous_drag"], *ON["gravity"]]
    run = kf.pull("cantilever", overrides, out=tmp_path / "run")
    summary = run.summary
    assert set(summary["effects"]) == {"elasticity", "gravity", "viscous_drag"}
    assert set(summary["absent_effects"]) == {effect.name for effect in EFFECTS} - set(summary["effects"])
    table = run.table("force")
    taken = table["viscous_drag_Nmm"][-1]
    assert taken > 0.0
    assert abs(table["missing_Nmm"][-1]) < 0.05 * taken


def test_costs_of_effects_and_solver_add_up(tmp_path) -> None:
    summary = kf.pull("cantilever", [*SMALL, "steps.0.duration=1 s"], out=tmp_path / "run").summary
    total = sum(phase["cpu_s"] for phase in summary["phases"].values())
    effects = summary["effects"]
    booked = sum(effect["cpu_s"] for effect in effects.values()) + sum(summary["solver_cpu_s"].values())
    assert booked + summary["costs"]["output"]["cpu_s"] + summary["other_cpu_s"] == pytest.approx(total, abs=1e-9)
    assert -0.01 * total < summary["other_cpu_s"] < total
    assert all(effect["share"] == pytest.approx(effect["cpu_s"] / total) for effect in effects.values())
    assert 0.5 < summary["min_jacobian"] < 1.0


def test_nothing_is_searched_while_tying_or_without_contact(monkeypatch) -> None:
    calls = {"search": 0}
    original = pairs.find_pairs

    def counted(*arguments):
        calls["search"] += 1
        return original(*arguments)

    monkeypatch.setattr(pairs, "find_pairs", counted)
    kf.pull("cantilever", [*BARE, "steps.0.duration=0.1 s"])
    kf.tie("cantilever", [*BARE, *ON["friction"], "steps=[]"])
    assert calls["search"] == 0
    kf.pull("cantilever", [*BARE, *ON["friction"], "steps.0.duration=0.1 s"])
    assert calls["search"] > 0


@pytest.mark.parametrize("name", list(ON))
def test_matrix_type_follows_from_the_effects(name: str) -> None:
    model = model_of(*ON[name])
    origin = State.of(Motion.at_rest(np.concatenate([rod.mesh.nodes for rod in model.body.rods])), {})
    system = model.equations(model.scene.steps[0], origin, {}).system
    assert system.symmetric is ("friction" not in name)
    system.close()


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
