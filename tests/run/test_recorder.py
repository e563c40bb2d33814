"""What is recorded of a run beside its checkpoints."""

import pytest

from knotfem.errors import InputError
from knotfem.models.base import Additions
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.directory import RunDirectory
from knotfem.run.disk import DiskStore
from knotfem.run.memory import MemoryStore
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import Simulation
from knotfem.scene import load_scene
from knotfem.solver.term import Role, Term


@pytest.mark.parametrize("rows", [{}, {"series": 3}])
def test_states_stored_before_outlive_a_session_without_fields(tmp_path, rows):
    scene = load_scene("cantilever", ["model=rod", "output.fields=false"])
    for store in (DiskStore(RunDirectory.create(scene, tmp_path / "run")), MemoryStore()):
        recorder = Recorder(Simulation(scene), store)
        recorder.begin(RunCheckpoint({}, recorder.summary.state(), rows) if rows else None)
        assert recorder.rows()["series"] == rows.get("series", 0)


def recorder_of(*terms: tuple[str, Role]) -> Recorder:
    """Of the cantilever, with terms of these names and roles besides its own."""
    made = []
    for name, role in terms:
        made.append(Term())
        made[-1].name, made[-1].role = name, role
    scene = load_scene("cantilever", ["model=rod", "output.fields=false"])
    return Recorder(Simulation(scene, additions=Additions(made)), MemoryStore())


@pytest.mark.parametrize(
    "terms",
    [
        [("elastic", Role.FIELD)],
        [("missing", Role.RESISTANCE)],
        [("gravity", Role.RESISTANCE)],
        [("drag", Role.FIELD)],
        [("wind", Role.FIELD), ("wind", Role.RESISTANCE)],
        [("side wind", Role.FIELD), ("side_wind", Role.FIELD)],
    ],
)
def test_term_whose_energy_would_hide_another_is_refused(terms):
    with pytest.raises(InputError, match=f"terms: its energy has the column of another; found {terms[-1][0]}"):
        recorder_of(*terms).begin()


def test_energies_of_terms_stand_in_columns_of_their_own(tmp_path):
    recorder = recorder_of(("wind", Role.FIELD), ("wind", Role.FIELD), ("gravity", Role.FIELD), ("friction", Role.LOAD))
    recorder.begin()
    store = recorder.store
    assert isinstance(store, MemoryStore)
    columns = store.tables["force"].columns
    assert columns.count("wind_Nmm") == columns.count("gravity_Nmm") == columns.count("friction_Nmm") == 1
