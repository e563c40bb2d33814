"""A search for an accuracy with real runs: a coarse knot of discrete rods that is pulled a little."""

from pathlib import Path

import pytest

import knotfem as kf
from knotfem.study.accuracy_check import run as module

KNOT = {
    "model": "rod",
    "rods.rod.length": "400 mm",
    "rods.rod.mesh.element_length": "8 mm",
    "contact.sample_spacing_over_diameter": 0.25,
    "tie.path": "direct",
    "steps.pull.displacement": "2 mm",
    "output.every_displacement": "2 mm",
}
"""Of the scene "overhand"."""


def test_error_of_a_coarse_knot_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "stored", list)
    scene = kf.load_scene("overhand", KNOT)
    found = kf.check_accuracy(scene, 0.9, out=tmp_path / "knot", jobs=1, progress=False)
    assert found.reached
    assert {change.choice for change in found.changes} >= {"slice", "step", "penalty", "rate"}
    errors = {change.choice: change.error for change in found.changes}
    assert errors["slice"] == max(errors.values()) > errors["tolerance"] > 0.0
    assert (tmp_path / "knot" / "force.png").exists()
    assert len(list((tmp_path / "knot-check" / "runs").iterdir())) == 1 + len(found.changes)
    again = kf.pull(tmp_path / "knot", out=tmp_path / "knot", progress=False)
    assert again.summary["accuracy"]["estimate"] == found.estimate, "the result is a run that has ended"
