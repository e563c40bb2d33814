"""What a reader of forces is told."""

from pathlib import Path

import numpy as np
import pytest

from knotfem.results.data import open_run
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import write_table
from knotfem.scene import load_scene


@pytest.mark.parametrize(("tolerance", "told"), [("1e-5 N", ""), ("1e-3 N", "0.05 of it; 0.0002 N would promise 1%")])
def test_a_tolerance_that_does_not_promise_the_force_is_told(tmp_path: Path, tolerance: str, told: str) -> None:
    run = RunDirectory.create(load_scene("overhand", [f"solver.force_tolerance={tolerance}"]), tmp_path / "run")
    pulled = np.array([1.0, 2.0])
    columns = {"time_s": pulled, "displacement_mm": pulled, "step_displacement_mm": pulled, "force_N": 0.1 * pulled}
    write_table(run.path / "force.csv", {**columns, "step": np.array(["pull", "pull"])})
    notes = open_run(run.path).notes
    assert len(notes) == bool(told)
    assert told in "".join(notes)
