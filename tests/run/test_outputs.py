"""What a run writes beside its checkpoints."""

from types import SimpleNamespace
from typing import Any

import pytest

from knotfem.run.directory import RunDirectory
from knotfem.run.outputs import Outputs
from knotfem.scene import load_scene


@pytest.mark.parametrize("rows", [{}, {"series": 3}])
def test_states_stored_before_outlive_a_session_without_fields(tmp_path, rows):
    scene = load_scene("bowline", ["output.fields=false"])
    model: Any = SimpleNamespace(scene=scene, effects=[], diameter=6.0, absent={}, dofs=30, hexes=4, segments=0)
    outputs = Outputs(RunDirectory.create(scene, tmp_path / "run"), model)
    outputs.begin({"rows": rows} if rows else None)
    assert outputs.rows()["rows"]["series"] == rows.get("series", 0)
