"""What a scene of the rod model does not call for is neither imported nor made nor visited, and is listed with why."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from knotfem.models.registry import REGISTRY
from knotfem.models.rod.reduced import Reduced
from knotfem.run import driver
from knotfem.run.check import check
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene import load_scene

BARE = (
    "model=rod", "rods.0.length=40 mm", "rods.0.mesh.element_length=4 mm", "output.fields=false", "solver.threads=1",
    "rods.0.core=none", "gravity=none", "drag=none", "steps.0.duration=0.1 s",
)  # fmt: skip
PEG = "obstacles=[{diameter='9 mm', axis=[0,1,0], point=['0 mm','0 mm','-9 mm'], friction=%g}]"
TOUCHING = ("contact.enabled=true", "contact.friction=0")
ON = {
    "core": ("rods.0.core={youngs_modulus='75.5 GPa', radius='0.127 mm'}",),
    "internal damping": ("rods.0.material.relaxation_time=0.01 s",),
    "inertia": ("inertia.scheme=backward-euler",),
    "drag": ("drag.rate=10 1/s",),
    "gravity": ("gravity.acceleration=9.81 m/s^2",),
    "viscous_drag": ("effects.viscous_drag={normal='2 Pa s', tangential='1 Pa s'}",),
    "contact": TOUCHING,
    "friction": ("contact.enabled=true", "contact.friction=0.3"),
    "cylinder": (*TOUCHING, PEG % 0.0),
    "cylinder friction": (*TOUCHING, PEG % 0.4),
}
"""Overrides of the bare scene that call for an effect."""
ELASTIC = {"frames", "stretch", "bend", "twist"}
MODULES = {
    "internal damping": {"models.rod.damping", "models.rod.damping_kernels"},
    "contact": {f"contact.{name}" for name in ("curve_contact", "curve_contact_kernels", "curve", "curve_search")},
    "friction": {"contact.curve_friction", "contact.curve_friction_kernels"},
    "cylinder": {"contact.curve_cylinder", "contact.curve_cylinder_kernels"},
}
"""By the effect that needs them."""


def scene_of(*overrides: str):
    return load_scene("cantilever", [*BARE, *overrides])


@pytest.mark.parametrize("name", list(ON))
def test_a_scene_turns_each_effect_on_by_itself(name: str) -> None:
    bare, shown = check(scene_of()), check(scene_of(*ON[name]))
    assert set(bare["effects"]) == ELASTIC
    assert set(bare["absent"]) == {registered.name for registered in REGISTRY}
    assert name in shown["effects"]
    assert name not in shown["absent"]
    assert set(shown["absent"]) | set(shown["effects"]) >= set(bare["absent"])
    assert shown["system"].startswith("unsymmetric (" + name if "friction" in name else "symmetric")
    assert "in full" in shown["system"]


def test_mass_is_made_only_for_who_asks() -> None:
    for name in ON:
        asks = name in ("inertia", "drag", "gravity")
        assert ("mass" in vars(Reduced(scene_of(*ON[name])).rod)) == asks


def test_no_friction_of_a_cylinder_is_made_without_a_coefficient() -> None:
    for friction, made in ((0.0, False), (0.4, True)):
        model = Reduced(scene_of(*TOUCHING, PEG % friction))
        assert bool(model.named("cylinder friction")) == made
        ((_, rubbing),) = model.rod.cylinders
        assert (rubbing is not None) == made


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


@pytest.mark.parametrize("overrides", [(), TOUCHING], ids=["bare", "contact"])
def test_a_whole_run_imports_no_absent_effect(tmp_path, overrides: tuple[str, ...]) -> None:
    arguments = [sys.executable, "-c", IMPORTS, json.dumps([*BARE, *overrides]), str(tmp_path / "run")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    found = set(json.loads(done.stdout.splitlines()[-1]))
    assert "knotfem.models.rod.bend" in found
    present = {"contact"} if overrides else set()
    for name, modules in MODULES.items():
        assert bool({f"knotfem.{module}" for module in modules} & found) == (name in present), name
    assert not found & {"knotfem.contact.material_points", "knotfem.models.rod.mass"}
    assert not found & {f"knotfem.models.solid.{module}" for module in ("hexahedra", "elasticity", "body")}
    others = {registered.module for registered in REGISTRY} - {"knotfem.terms.load"}
    assert not found & {module for module in others if not module.startswith("knotfem.models.rod.")}


def test_a_run_visits_each_effect_that_is_there_and_no_other(tmp_path) -> None:
    scene = scene_of(*ON["internal damping"], *ON["gravity"])
    run = RunDirectory.create(scene, tmp_path / "run")
    driver.pull(scene, run)
    summary = run.read_summary()
    assert set(summary["effects"]) == ELASTIC | {"internal damping", "gravity"}
    assert set(summary["absent_effects"]) == {registered.name for registered in REGISTRY} - set(summary["effects"])


@pytest.mark.parametrize(
    "nothing",
    [
        ("drag.rate=0 1/s",),
        ("rods.0.material.relaxation_time=0 s",),
        ("effects.viscous_drag={normal='0 Pa s', tangential='0 Pa s'}",),
        (*TOUCHING, PEG.replace("-9 mm", "-30 mm") % 0.0),
    ],
)
def test_a_coefficient_of_zero_changes_nothing(tmp_path, nothing: tuple[str, ...]) -> None:
    ends = []
    for name, overrides in (("bare", ()), ("nothing", nothing)):
        scene = scene_of(*ON["gravity"], *overrides)
        run = RunDirectory.create(scene, tmp_path / name)
        driver.pull(scene, run)
        ends.append(np.array(read_table(run.path / "force.csv")["elastic_Nmm"]))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-12)
