"""Discrete rods that set out from a three-dimensional run, from tying to pulling."""

from pathlib import Path

import numpy as np
import pytest

from knotfem.run.directory import SOURCE, RunDirectory
from knotfem.run.driver import drive
from knotfem.run.tables import read_table
from knotfem.scene import load_scene

COARSE = (
    "rods.0.length=400 mm",
    "rods.0.mesh.section_elements=4",
    "rods.0.mesh.element_length=8 mm",
    "contact.sample_spacing_over_diameter=0.25",
    "output.fields=false",
    "tie.path=inextensible",
    "steps.1.displacement=1 mm",
    "solver.threads=1",
)


def begun(path: Path, *overrides: str) -> RunDirectory:
    return RunDirectory.create(load_scene("overhand", [*COARSE, *overrides]), path)


def last_profile(run: RunDirectory) -> tuple[np.ndarray, float]:
    """Points of the rod in the last state [mm], and the normal forces in it, summed [N]."""
    profile, contacts = read_table(run.path / "tension.csv"), read_table(run.path / "contacts.csv")
    rows = profile["time_s"] == profile["time_s"][-1]
    points = np.stack([profile[axis][rows] for axis in ("x_mm", "y_mm", "z_mm")], axis=1)
    return points, float(contacts["normal_force_N"][contacts["time_s"] == profile["time_s"][-1]].sum())


@pytest.fixture(scope="module")
def solid(tmp_path_factory: pytest.TempPathFactory) -> RunDirectory:
    run = begun(tmp_path_factory.mktemp("source") / "solid")
    drive(run, "tie")
    return run


def test_a_knot_tied_in_three_dimensions_comes_to_rest_as_a_rod_and_is_pulled(solid, tmp_path):
    points, pressed = last_profile(solid)
    run = begun(tmp_path / "light", "model=rod", f'tie.source="{solid.path}"')
    drive(run, "tie")
    settled, presses = last_profile(run)
    assert np.abs(settled - points).max() < 0.25 * run.scene.rods[0].diameter
    assert presses == pytest.approx(pressed, rel=0.25)
    away = solid.path.rename(solid.path.with_name("away"))
    drive(run, "pull")
    on = run.branch(run.scene, tmp_path / "on")
    drive(on, "pull")
    away.rename(solid.path)
    force = read_table(run.path / "force.csv")["force_N"]
    assert force[-1] > force[0]
    assert np.array_equal(read_table(on.path / "force.csv")["force_N"], force)
    assert (on.path / SOURCE).read_bytes() == (run.path / SOURCE).read_bytes()
