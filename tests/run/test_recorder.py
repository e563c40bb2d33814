"""What is recorded of a run beside its checkpoints."""

import pytest

from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.directory import RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.run.memory import MemoryStore
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import Simulation
from knotfem.scene import load_scene


@pytest.mark.parametrize("rows", [{}, {"series": 3}])
def test_states_stored_before_outlive_a_session_without_fields(tmp_path, rows):
    scene = load_scene("cantilever", ["model=rod", "output.fields=false"])
    for store in (DiskStore(RunDirectory.create(scene, tmp_path / "run")), MemoryStore()):
        recorder = Recorder(Simulation(scene), store)
        recorder.begin(RunCheckpoint({}, recorder.summary.state(), rows) if rows else None)
        assert recorder.rows()["series"] == rows.get("series", 0)
