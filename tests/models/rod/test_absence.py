"""What a scene of the rod model does not call for is neither imported nor made nor visited, and is listed with why."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

import knotfem as kf
from knotfem.contact.friction import Friction
from knotfem.contact.obstacle import ObstacleContact
from knotfem.models.effects import EFFECTS
from knotfem.models.rod.model import RodModel
from knotfem.run.check import check

BARE = (
    "model=rod", "rods.0.length=40 mm", "rods.0.mesh.element_length=4 mm", "output.fields=false", "solver.threads=1",
    "rods.0.core=none", "gravity=none", "drag=none", "inertia.scheme=quasi-static",
    "steps.0.duration=0.1 s", "steps.0.rate=real",
)  # fmt: skip
PEG = "obstacles=[{diameter='9 mm', axis=[0,1,0], point=['0 mm','0 mm','-9 mm'], friction=%g}]"
TOUCHING = ("contact.enabled=true", "contact.friction=0")
ON = {
    "core": ("rods.0.core={youngs_modulus='75.5 GPa', radius='0.127 mm'}",),
    "internal damping": ("rods.0.material.relaxation_time=0.01 s",),
    "inertia": ("inertia.scheme=backward-euler",),
    "drag": ("drag.rate=10 1/s",),
    "numerical_drag": ("steps.0.rate=quasi-static",),
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
    "inertia": {"terms.inertia"},
    "gravity": {"terms.gravity"},
    "viscous_drag": {"terms.viscous"},
    "load": {"terms.load"},
    "contact": {f"contact.{name}" for name in ("pairs", "curve_pairs", "curve", "search")},
    "friction": {"contact.curve_friction"},
    "any friction": {"contact.friction", "contact.slip", "contact.material_points"},
    "cylinder": {"contact.obstacle"},
    "cylinder friction": {"contact.curve_obstacle_friction"},
}
"""By the effect that needs them."""


def scene_of(*overrides: str):
    return kf.load_scene("cantilever", [*BARE, *overrides])


@pytest.mark.parametrize("name", list(ON))
def test_a_scene_turns_each_effect_on_by_itself(name: str) -> None:
    bare, shown = check(scene_of()), check(scene_of(*ON[name]))
    assert set(bare["effects"]) == ELASTIC - {"frames"}
    assert set(bare["absent"]) == {effect.name for effect in EFFECTS}
    assert name in shown["effects"]
    assert name not in shown["absent"]
    assert set(shown["absent"]) | set(shown["effects"]) >= set(bare["absent"])
    assert shown["system"].startswith("unsymmetric (" + name if "friction" in name else "symmetric")
    assert "in full" in shown["system"]


def test_mass_is_made_only_for_who_asks() -> None:
    for name in ON:
        asks = name in ("inertia", "drag", "numerical_drag", "gravity")
        assert ("mass" in vars(RodModel(scene_of(*ON[name])).discrete)) == asks


def test_no_friction_of_a_cylinder_is_made_without_a_coefficient() -> None:
    for friction, names in ((0.0, []), (0.4, ["cylinder friction"])):
        terms = RodModel(scene_of(*TOUCHING, PEG % friction)).terms
        assert [term.name for term in terms if isinstance(term, Friction)] == names
        assert len([term for term in terms if isinstance(term, ObstacleContact)]) == 1


IMPORTS = """
from pathlib import Path
import json, sys
import knotfem as kf
out = sys.argv[2] or None
kf.pull("cantilever", json.loads(sys.argv[1]), out=out, progress=False)
print(json.dumps(sorted(name for name in sys.modules if name.startswith("knotfem."))))
"""


@pytest.mark.parametrize(
    ("overrides", "present"),
    [
        ((), set()),
        (TOUCHING, {"contact"}),
        ((*TOUCHING, PEG % 0.4), {"contact", "any friction", "cylinder", "cylinder friction"}),
    ],
    ids=["bare", "contact", "cylinder"],
)
@pytest.mark.parametrize("where", ["in memory", "on disk"])
def test_a_whole_run_imports_no_absent_effect(
    tmp_path, where: str, overrides: tuple[str, ...], present: set[str]
) -> None:
    out = str(tmp_path / "run") if where == "on disk" else ""
    arguments = [sys.executable, "-c", IMPORTS, json.dumps([*BARE, *overrides]), out]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    found = set(json.loads(done.stdout.splitlines()[-1]))
    assert "knotfem.models.rod.bend" in found
    for name, modules in MODULES.items():
        its_own = {f"knotfem.{module}" for module in modules}
        assert its_own & found == (its_own if name in present else set()), name
    assert "knotfem.models.rod.mass" not in found
    assert not {name for name in found if name.startswith("knotfem.models.solid.") or ".tube" in name}


def test_a_run_visits_each_effect_that_is_there_and_no_other() -> None:
    summary = kf.pull(scene_of(*ON["internal damping"], *ON["gravity"]), progress=False).summary
    assert set(summary["effects"]) == ELASTIC | {"internal damping", "gravity"}
    assert set(summary["absent_effects"]) == {effect.name for effect in EFFECTS} - set(summary["effects"])


@pytest.mark.parametrize(
    "nothing",
    [
        ("drag.rate=0 1/s",),
        ("rods.0.material.relaxation_time=0 s",),
        ("effects.viscous_drag={normal='0 Pa s', tangential='0 Pa s'}",),
        (*TOUCHING, PEG.replace("-9 mm", "-30 mm") % 0.0),
    ],
)
def test_a_coefficient_of_zero_changes_nothing(nothing: tuple[str, ...]) -> None:
    ends = [
        kf.pull(scene_of(*ON["gravity"], *overrides), progress=False).table("force")["elastic_Nmm"]
        for overrides in ((), nothing)
    ]
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-12)
