"""What a reader of forces is told."""

from pathlib import Path

import numpy as np
import pytest

from knotfem.results.data import open_run
from knotfem.results.force import force_at
from knotfem.results.moment import Moment
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


def test_where_ends_are_let_go_at_one_displacement_a_state_has_the_force_of_its_own_step(tmp_path: Path) -> None:
    run = RunDirectory.create(load_scene("sheet-bend"), tmp_path / "run")
    table = {
        "time_s": np.array([15.0, 16.0, 16.0, 16.0, 17.0]),
        "displacement_mm": np.array([57.0, 60.0, 60.0, 60.0, 63.0]),
        "step_displacement_mm": np.array([57.0, 60.0, 0.0, 0.0, 3.0]),
        "force_N": np.array([3.5, 4.8, 2.0, 0.3, 0.4]),
        "equilibrium": np.array([1, 1, 0, 1, 1]),
        "step": np.array(["tighten", "tighten", "pull", "pull", "pull"]),
    }
    write_table(run.path / "force.csv", table)
    done = open_run(run.path)
    assert force_at(done, Moment("tighten", 60.0, 60.0, 16.0)) == 4.8
    assert force_at(done, Moment("pull", 60.0, 0.0, 16.0)) == 0.3
    assert force_at(done, Moment("pull", 63.0, 3.0, 17.0)) == 0.4
    assert force_at(done, Moment("relax", 0.0, 0.0, 1.0)) == 0.0
    assert done.force.at(np.array([60.0, 61.5])) == pytest.approx([4.8, 0.35])
