"""Whole runs of coarse scenes, of either model: what they write, how they stop and go on, how they balance."""

from __future__ import annotations

import json

import numpy as np
import pytest

from knotfem.errors import InputError, Interrupted, KnotLost, NotConverged, Stopped
from knotfem.results.data import open_run
from knotfem.results.figures import RunFigures
from knotfem.run import checkpoint
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import Driver, drive, goal_of
from knotfem.run.monitor import KnotMonitor
from knotfem.run.stop import StopRequest
from knotfem.run.tables import read_table
from knotfem.scene import load_scene

COARSE = (
    "rods.0.length=400 mm",
    "rods.0.diameter=6 mm",
    "rods.0.mesh.section_elements=4",
    "rods.0.mesh.element_length=5 mm",
    "contact.sample_spacing_over_diameter=0.25",
    "output.fields=false",
    "tie.increments=2",
    "steps.1.displacement=6 mm",
    "solver.threads=1",
)
MODELS = ("fem", "rod")


def tie(run: RunDirectory) -> None:
    drive(run, "tie")


def pull(run: RunDirectory) -> None:
    drive(run, "pull")


def resume(path) -> None:
    """Go on with a run that another process might have left."""
    run = RunDirectory.open(path)
    drive(run, goal_of(run))


def coarse(*overrides: str, scene: str = "overhand"):
    return load_scene(scene, [*COARSE, *overrides])


@pytest.fixture(scope="module", params=MODELS)
def pulled(request, tmp_path_factory) -> RunDirectory:
    scene = coarse(f"model={request.param}")
    run = RunDirectory.create(scene, tmp_path_factory.mktemp("driver") / "run")
    drive(run, "pull", figures=RunFigures())
    return run


def rows(run: RunDirectory, table: str) -> dict[str, np.ndarray]:
    columns = read_table(run.path / table)
    return {name: values for name, values in columns.items() if name != "wall_s"}


def test_pulled_run_writes_all_its_files(pulled):
    names = {path.name for path in pulled.path.iterdir()}
    assert {
        "scene.toml", "provenance.json", "status.json", "log.jsonl", "tie.csv", "force.csv", "tension.csv",
        "summary.json", "checkpoints", "force.png", "tension.png", "stretch.png", "contacts.csv",
    } <= names  # fmt: skip
    assert ("twist.csv" in names) == (pulled.scene.model == "rod")
    assert pulled.read_status()["state"] == "done"
    summary = pulled.read_summary()
    assert summary["knot_before"] == summary["knot_after"] == "3_1"
    assert set(summary["phases"]) == {"mapping", "relax", "pull"}


def test_force_rises_and_balances(pulled):
    force = read_table(pulled.path / "force.csv")
    assert force["displacement_mm"][-1] == pytest.approx(6.0, abs=1e-9)
    assert force["force_N"][-1] > force["force_N"][0] > -0.05
    assert force["imbalance_N"][-1] < 5e-3 * force["force_N"][-1]
    assert abs(force["missing_Nmm"][-1]) < 0.02 * force["work_Nmm"][-1]
    assert np.all(np.diff(force["friction_Nmm"]) > -1e-3 * force["work_Nmm"][-1])


def test_tension_equals_the_applied_force_at_the_ends(pulled):
    profile, force = open_run(pulled.path).tension().table, read_table(pulled.path / "force.csv")["force_N"][-1]
    assert profile["tension_N"][0] == pytest.approx(force, rel=2e-3)
    apart = np.abs(profile["core_N"] + profile["bulk_N"] - profile["tension_N"])
    assert np.median(apart) < 0.01 * force


def test_contacts_lie_on_the_rod_and_rub_within_their_limit(pulled):
    found = read_table(pulled.path / "contacts.csv")
    assert found["normal_force_N"].size > 20
    assert np.all(found["normal_force_N"] > 0.0)
    for column in ("arclength_mm", "other_arclength_mm"):
        assert np.all((found[column] > 20.0) & (found[column] < 380.0))
    assert np.all(np.abs(found["arclength_mm"] - found["other_arclength_mm"]) > 9.0)
    mobilised = found["friction_force_N"] / (0.33 * found["normal_force_N"])
    assert mobilised.max() < 1.0 + 1e-6
    slips = found["state"] == "slips"
    assert 0 < slips.sum() < slips.size
    assert np.all(mobilised[slips] > 0.998)
    assert set(found["other"]) == {"rod"}


def stop_after(asked: int, patch: pytest.MonkeyPatch) -> None:
    """Let a stop be due once a run has asked so often; a run asks before each Newton iteration and after each step."""
    calls = {"left": asked}

    def due(self) -> bool:
        calls["left"] -= 1
        return calls["left"] < 0

    patch.setattr(StopRequest, "due", property(due))


def stopped_halfway(scene, path, whole: RunDirectory, monkeypatch) -> RunDirectory:
    """A run of the scene that is stopped amid its last step, amid the iterations of a time step, and resumed."""
    run = RunDirectory.create(scene, path)
    summary, force = whole.read_summary(), read_table(whole.path / "force.csv")
    in_last = int(force["newton_iterations"].sum() + force["time_s"].size)
    with monkeypatch.context() as patch:
        stop_after(summary["newton_iterations"] + summary["steps"] - in_last // 2, patch)
        with pytest.raises(Stopped):
            pull(run)
    assert run.read_status()["state"] == "stopped"
    resume(run.path)
    return run


def assert_same_bits(whole: RunDirectory, other: RunDirectory, *tables: str) -> None:
    for table in tables:
        expected, found = rows(whole, table), rows(other, table)
        for name, values in expected.items():
            assert np.array_equal(values, found[name]), f"{table}: {name}"


def test_stopped_run_goes_on_to_the_same_bits(pulled, tmp_path, monkeypatch):
    run = stopped_halfway(pulled.scene, tmp_path / "stopped", pulled, monkeypatch)
    assert_same_bits(pulled, run, "force.csv", "tension.csv", "contacts.csv")


def test_stopped_run_of_graded_slices_goes_on_to_the_same_bits(tmp_path, monkeypatch):
    scene = coarse(
        "model=rod", "rods.0.mesh.element_length=8 mm", "rods.0.mesh.turning_angle=0.3", "steps.1.displacement=2 mm"
    )
    whole = RunDirectory.create(scene, tmp_path / "whole")
    pull(whole)
    run = stopped_halfway(scene, tmp_path / "stopped", whole, monkeypatch)
    assert_same_bits(whole, run, "force.csv", "tension.csv", "contacts.csv", "twist.csv")


LOADED = (
    "rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=8 mm", "output.fields=false", "solver.threads=1",
    'steps=[{kind="load",duration="1 s",ends={rod={end={motion="loaded",force="0.02 N",direction=[1,0,0]}}}}]',
)  # fmt: skip


@pytest.mark.parametrize("model", MODELS)
def test_stopped_load_goes_on_to_the_same_bits(tmp_path, monkeypatch, model):
    scene = load_scene("cantilever", [f"model={model}", *LOADED])
    whole = RunDirectory.create(scene, tmp_path / "whole")
    pull(whole)
    run = stopped_halfway(scene, tmp_path / "stopped", whole, monkeypatch)
    assert_same_bits(whole, run, "force.csv", "tension.csv")


def test_state_after_a_step_is_gone_on_from_to_the_same_bits(tmp_path):
    """From the tied knot on, in one go and in two commands."""
    scene = coarse("model=rod", "rods.0.mesh.element_length=8 mm", "steps.1.displacement=2 mm")
    once, twice = (RunDirectory.create(scene, tmp_path / name) for name in ("once", "twice"))
    pull(once)
    tie(twice)
    pull(twice)
    assert_same_bits(once, twice, "force.csv", "tension.csv", "twist.csv")


def test_knot_that_is_tied_by_the_mapping_alone_is_saved_once(tmp_path):
    scene = coarse("model=rod", "contact.enabled=false", "steps.1.displacement=1 mm", "steps.0=none")
    run = RunDirectory.create(scene, tmp_path / "run")
    tie(run)
    assert [path.name for path in run.checkpoints.paths()] == ["checkpoint-000001-tied.h5"]
    pull(run)
    assert run.checkpoints.named("tied") == run.checkpoints.paths()[0]


def test_checkpoint_is_read_once_when_a_run_goes_on(tmp_path, monkeypatch):
    scene = coarse(*QUICK)
    run = RunDirectory.create(scene, tmp_path / "run")
    tie(run)
    read, reading = [], checkpoint.read_checkpoint
    monkeypatch.setattr(checkpoint, "read_checkpoint", lambda path: read.append(path) or reading(path))
    pull(run)
    assert len(read) == 1


def test_paths_of_the_mapping_end_in_the_same_equilibrium(tmp_path):
    ends = {}
    for path in ("direct", "inextensible", "linear"):
        scene = coarse(f"tie.path={path}", "tie.optimise_direction=false")
        run = RunDirectory.create(scene, tmp_path / path)
        tie(run)
        profile = open_run(run.path).tension().table
        ends[path] = np.stack([profile[f"{axis}_mm"] for axis in "xyz"], axis=1)
    assert np.abs(ends["inextensible"] - ends["direct"]).max() < 1e-3
    assert np.abs(ends["linear"] - ends["direct"]).max() < 1e-3


@pytest.mark.parametrize("model", MODELS)
def test_hopeless_tolerance_is_a_failure_with_its_state_saved(tmp_path, model):
    scene = coarse(
        f"model={model}", "solver.force_tolerance=1e-13 N", "solver.max_iterations=3", "solver.max_cutbacks=0"
    )
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(NotConverged):
        tie(run)
    status = run.read_status()
    assert status["state"] == "failed"
    assert status["fraction"] < 1.0 if status["phase"] == "mapping" else status["fraction"] == 0.0
    assert json.loads((run.path / "provenance.json").read_text())


LIMP = ("contact.stiffness_over_modulus=1e-9", "contact.line_stiffness_over_hertz=1e-9")
"""Contact that holds nothing back."""


def assert_lost(run: RunDirectory, message: str) -> None:
    """The run ends with a lost knot, and with the same when it is resumed."""
    with pytest.raises(KnotLost, match=message) as first:
        pull(run)
    with pytest.raises(KnotLost) as again:
        resume(run.path)
    assert str(again.value) == str(first.value)
    assert run.read_status()["state"] == "failed"


def test_strand_that_passes_through_another_ends_the_run(tmp_path):
    scene = coarse("model=rod", *LIMP, "steps.1.displacement=120 mm")
    assert_lost(RunDirectory.create(scene, tmp_path / "run"), "passed through")


def test_knot_that_is_lost_at_the_end_of_a_step_ends_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(KnotMonitor, "check_interpenetration", lambda *arguments: None)
    pull = '{kind="pull",displacement="120 mm",speed="4 mm/s",ends={rod={start={motion="driven",direction=[1,0,0]}}}}'
    scene = coarse("model=rod", *LIMP, f"steps=[{pull}]", "output.every_displacement=120 mm")
    assert_lost(RunDirectory.create(scene, tmp_path / "run"), "pull: .* come undone")


@pytest.mark.parametrize("model", MODELS)
def test_without_contact_no_knot_is_watched_over(tmp_path, monkeypatch, model):
    calls = []
    monkeypatch.setattr(KnotMonitor, "check_interpenetration", lambda *arguments: calls.append("interpenetration"))
    monkeypatch.setattr(KnotMonitor, "lost", lambda *arguments: calls.append("lost"))
    scene = coarse(f"model={model}", "contact.enabled=false", "steps.1.displacement=120 mm")
    run = RunDirectory.create(scene, tmp_path / "run")
    pull(run)
    assert not calls
    assert run.read_summary()["knot_before"] == "3_1"


def full(self) -> None:
    raise InputError("No space left")


@pytest.mark.parametrize(
    ("error", "state"),
    [
        (AssertionError("a bug"), "failed"),
        (MemoryError(), "failed"),
        (KeyboardInterrupt(), "stopped"),
        (NotConverged("hopeless"), "failed"),
    ],
)
def test_whatever_ends_a_run_is_recorded_and_raised_also_on_a_full_disk(tmp_path, monkeypatch, error, state):
    def end(self) -> None:
        raise error

    monkeypatch.setattr(Driver, "go", end)
    monkeypatch.setattr(Driver, "finish", full)
    scene = load_scene("cantilever", LOADED)
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(type(error)) as raised:
        pull(run)
    assert raised.value is error
    assert run.read_status()["state"] == state
    provenance = json.loads((run.path / "provenance.json").read_text())
    assert provenance["exit_reason"].startswith(f"{state}: ")
    assert provenance["end"] is not None


def test_a_finished_run_is_left_as_it_is(tmp_path):
    run = RunDirectory.create(
        coarse("model=rod", "contact.enabled=false", "steps.1.displacement=1 mm"), tmp_path / "run"
    )
    pull(run)
    before = {path.name: path.read_bytes() for path in run.path.iterdir() if path.is_file()}
    assert run.read_status()["phase"] == "pull"
    resume(run.path)
    pull(run)
    assert {path.name: path.read_bytes() for path in run.path.iterdir() if path.is_file()} == before


def test_run_that_cannot_write_its_summary_has_failed(tmp_path, monkeypatch):
    monkeypatch.setattr(Driver, "go", lambda self: None)
    monkeypatch.setattr(Driver, "finish", full)
    scene = load_scene("cantilever", LOADED)
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(InputError, match="No space left"):
        pull(run)
    assert run.read_status()["state"] == "failed"


QUICK = ("model=rod", "rods.0.mesh.element_length=8 mm", "contact.enabled=false", "steps.1.displacement=1 mm")


def test_run_stopped_amid_the_mapping_begins_anew_to_the_same_bits(tmp_path, monkeypatch):
    scene = coarse(*QUICK)
    whole, run = (RunDirectory.create(scene, tmp_path / name) for name in ("whole", "stopped"))
    pull(whole)
    with monkeypatch.context() as patch:
        stop_after(0, patch)
        with pytest.raises(Stopped, match="the mapping is computed anew by knotfem resume"):
            pull(run)
    assert run.checkpoints.latest() is None
    resume(run.path)
    assert_same_bits(whole, run, "tie.csv", "force.csv", "tension.csv", "twist.csv")


def test_interrupt_is_told_from_a_request_to_stop(tmp_path, monkeypatch):
    scene = coarse(*QUICK)
    run = RunDirectory.create(scene, tmp_path / "run")
    stop_after(20, monkeypatch)
    monkeypatch.setattr(StopRequest, "error", lambda self, *kept: Interrupted("interrupted"))
    with pytest.raises(Interrupted):
        pull(run)
    status = run.read_status()
    assert (status["state"], status["exit_code"]) == ("stopped", 130)
    assert run.checkpoints.latest() is not None


@pytest.mark.parametrize("state", [{}, {"progress": {"motion": {"x": 1.0}}, "memory": {}, "outputs": {}}])
def test_checkpoint_of_an_older_version_is_refused_and_the_tables_stay(tmp_path, state):
    scene = coarse(*QUICK)
    run = RunDirectory.create(scene, tmp_path / "run")
    tie(run)
    metadata = {"goal": "pull", "next_step": 1, "inside": "pull", "rows": {"tie.csv": 1}}
    path = run.checkpoints.save(state, metadata, name="tied")
    before = (run.path / "tie.csv").read_bytes()
    for go_on in (resume, lambda path: pull(RunDirectory.open(path))):
        with pytest.raises(InputError, match="the checkpoint is of an older version; expected a new run") as refused:
            go_on(run.path)
        assert refused.value.file == path
    assert (run.path / "tie.csv").read_bytes() == before
    assert run.read_status()["state"] == "failed"


def test_session_that_takes_another_linear_solver_says_so(tmp_path):
    scene = coarse(*QUICK)
    run = RunDirectory.create(scene, tmp_path / "run")
    tie(run)
    run.override(["solver.linear=superlu"])
    pull(run)
    assert run.read_summary()["linear_solver"] == "superlu"
    assert json.loads((run.path / "provenance.json").read_text())["linear_solver"] == "superlu"


def test_time_of_a_step_that_was_not_accepted_counts(tmp_path):
    scene = coarse("model=rod", "solver.force_tolerance=1e-13 N", "solver.max_iterations=30", "solver.max_cutbacks=0")
    run = RunDirectory.create(scene, tmp_path / "run")
    with pytest.raises(NotConverged):
        tie(run)
    summary = run.read_summary()
    assert summary["steps"] == 0
    assert summary["phases"]["relax"]["cpu_s"] > 0.0
    assert summary["effects"]["contact"]["cpu_s"] > 0.0
    assert summary["factorisations"] > 0
