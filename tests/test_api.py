"""The public functions: in memory as on disk, with terms and obstacles of one's own, silent and without exits."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coarse import KNOT

import knotfem as kf
from knotfem.models.base import Model
from knotfem.run.directory import RunDirectory
from knotfem.run.monitor import KnotMonitor
from knotfem.run.stop import StopRequest
from knotfem.scene.steps import Pull
from knotfem.sparse.pattern import Matrix

BEAM = {"model": "rod", "rods.0.mesh.element_length": "8 mm", "output.fields": False, "solver.threads": 1}
"""Of the scene "cantilever"."""
TABLES = ("tie", "force", "tension", "twist", "contacts")


def assert_same_bits(one: kf.Run, other: kf.Run, *tables: str) -> None:
    for name in tables:
        expected, found = one.table(name), other.table(name)
        assert list(expected) == list(found)
        assert all(np.array_equal(expected[key], found[key]) for key in expected if key != "wall_s"), name


@pytest.fixture(scope="module")
def pulled() -> kf.Run:
    return kf.pull("overhand", KNOT)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> kf.Run:
    return kf.pull("overhand", KNOT, out=tmp_path_factory.mktemp("api") / "knot")


def test_memory_and_disk_agree_to_the_last_bit(pulled: kf.Run, stored: kf.Run) -> None:
    assert pulled.path is None
    assert stored.path is not None
    assert stored.path.joinpath("force.png").exists()
    assert_same_bits(pulled, stored, *TABLES)
    assert len(pulled.states) == len(stored.states) == 3
    for ours, theirs in zip(pulled.states, stored.states, strict=True):
        assert (ours.time, ours.displacement) == (theirs.time, theirs.displacement)
        assert np.array_equal(ours.points, theirs.points)
        assert np.array_equal(ours.fields.cells, theirs.fields.cells)
        for name, values in ours.fields.point_data.items():
            assert np.array_equal(values.astype(np.float32), theirs.fields.point_data[name].astype(np.float32)), name
    same = ("dofs", "steps", "newton_iterations", "cutbacks", "knot_before", "knot_after", "final_force_N")
    assert {key: pulled.summary[key] for key in same} == {key: stored.summary[key] for key in same}
    assert pulled.scene == stored.scene


def test_what_a_run_offers(pulled: kf.Run) -> None:
    force = pulled.force
    assert force.displacement[-1] == 3.0
    assert force.force[-1] == pulled.summary["final_force_N"] > force.force[0]
    assert force.at(3.0) == force.force[-1]
    profile = pulled.tension()
    assert profile.displacement == 3.0
    assert profile.tension[0] == pytest.approx(force.force[-1], rel=5e-3)
    assert profile.arclength[-1] == pytest.approx(400.0)
    assert pulled.tension(at="1.4 mm").displacement == pulled.tension(at=1.5).displacement == 1.5
    with pytest.raises(kf.InputError, match="no state is stored near this displacement; found 30 mm; expected 0 to"):
        pulled.tension(at="30 mm")
    found = pulled.contacts()
    assert found["normal_force_N"].size > 10
    assert set(found["other"]) == {"rod"}
    assert [state.displacement for state in pulled.states] == [0.0, 1.5, 3.0]
    assert pulled.state("1.5 mm").time == pulled.stored.choose(1.5).time
    energy = pulled.energy
    assert {"work", "elastic", "friction", "contact", "missing"} <= set(energy.names)
    assert abs(energy["missing"][-1]) < 0.05 * energy["work"][-1]
    with pytest.raises(kf.InputError, match="no such energy; found heat"):
        energy["heat"]
    assert list(pulled.cost.phases) == ["mapping", "relax", "pull"]
    assert pulled.cost.steps == pulled.summary["steps"] > 10
    assert pulled.cost.cpu_s == pytest.approx(sum(phase.cpu_s for phase in pulled.cost.phases.values()))
    assert pulled.knot == "3_1"
    assert repr(pulled) == "<knotfem run 'overhand', in memory>"


def test_curves_are_drawn_into_axes(pulled: kf.Run) -> None:
    from matplotlib.figure import Figure

    axes = Figure().subplots(2, 2).ravel()
    assert pulled.force.plot(axes[0]) is axes[0]
    assert axes[0].lines[0].get_xydata()[-1].tolist() == [3.0, pulled.force.force[-1]]
    assert len(pulled.tension().plot(axes[1]).lines) == 1
    assert pulled.energy.plot(axes[2]).get_ylabel() == "energy [N mm]"
    assert pulled.cost.plot(axes[3]).patches


def test_overrides_name_steps_and_rods() -> None:
    scene = kf.load_scene("overhand", KNOT)
    assert scene.rods[0].length == 400.0
    assert displacement(scene) == 3.0
    assert scene == kf.load_scene("overhand", [f"{key}={_text(value)}" for key, value in KNOT.items()])
    again = kf.load_scene(scene, {"steps.1.displacement": "4 mm", "drag": None})
    assert (displacement(again), again.drag, displacement(scene)) == (4.0, None, 3.0)
    with pytest.raises(kf.InputError, match=r"steps\.pul"):
        kf.load_scene("overhand", {"steps.pul.displacement": "3 mm"})
    with pytest.raises(kf.InputError, match="unit is missing"):
        kf.load_scene("overhand", {"rods.rod.length": 400})


def displacement(scene: kf.Scene) -> float:
    (pull,) = (step for step in scene.steps if isinstance(step, Pull))
    return pull.displacement


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def test_tied_knot_is_taken_up(pulled: kf.Run, stored: kf.Run, tmp_path: Path) -> None:
    """In memory or from files, into memory or files, always to the same bits; what was recorded of tying stays."""
    assert stored.path is not None
    changed = {"contact.friction": 0.2, "steps.pull.displacement": "1 mm"}
    first = kf.pull(pulled, changed)
    assert first.force.force[-1] != pulled.force.at(1.0)
    for other in (
        kf.pull(stored, changed),
        kf.pull(stored.path, changed),
        kf.pull(stored, changed, out=tmp_path / "on"),
    ):
        assert_same_bits(first, other, *TABLES)
        assert list(other.cost.phases) == ["mapping", "relax", "pull"]
        assert len(other.states) == len(first.states)
    with pytest.raises(kf.InputError, match="differs from the tied run"):
        kf.pull(pulled, {"rods.rod.diameter": "5 mm"})
    with pytest.raises(kf.InputError, match="a run in memory has no files to go on from"):
        kf.pull(pulled, out=tmp_path / "nothing")
    assert not (tmp_path / "nothing").exists()


def test_tie_and_pull_are_one_after_the_other_what_pull_is_alone(pulled: kf.Run, tmp_path: Path) -> None:
    knot = kf.tie("overhand", KNOT)
    assert not knot.table("force")["force_N"].size
    with pytest.raises(kf.InputError, match="no loading step is stored"):
        _ = knot.force
    assert_same_bits(kf.pull(knot), pulled, *TABLES)
    folder = tmp_path / "knot"
    kf.tie("overhand", KNOT, out=folder)
    assert_same_bits(kf.pull(folder, out=folder), pulled, *TABLES)
    with pytest.raises(kf.InputError, match="cannot change in a run"):
        kf.pull(folder, {"contact.friction": 0.2}, out=folder)
    with pytest.raises(kf.InputError, match="would replace its source"):
        kf.pull(folder, out=folder, force=True)


def test_a_run_that_is_not_tied_is_tied_first(pulled: kf.Run, tmp_path: Path) -> None:
    begun = RunDirectory.create(kf.load_scene("overhand", KNOT), tmp_path / "begun").path
    assert_same_bits(kf.pull(begun), pulled, *TABLES)
    with pytest.raises(kf.InputError, match="no run is in this folder"):
        kf.pull(tmp_path)


def test_folders_are_numbered_or_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    bent = {**BEAM, "steps.0.duration": "0.01 s", "steps.0.kind": "hold"}
    assert [str(kf.pull("cantilever", bent, out=True).path) for _ in range(2)] == [
        "runs/cantilever-1",
        "runs/cantilever-2",
    ]
    with pytest.raises(kf.InputError, match="holds a run already"):
        kf.tie("cantilever", bent, out="runs/cantilever-1")
    assert kf.tie("cantilever", bent, out="runs/cantilever-1", force=True).path == Path("runs/cantilever-1")
    assert kf.pull("cantilever", bent, out=False).path is None


def test_steps_come_as_they_are_accepted(pulled: kf.Run) -> None:
    forces = []
    for step in kf.steps("overhand", KNOT):
        assert step.state.x.shape[1] == 4
        if step.step.name == "pull":
            forces.append(step.force)
            if len(forces) == 3:
                break
    assert np.array_equal(forces, pulled.force.force[:3])
    pulling = [step.displacement for step in kf.steps(pulled)]
    assert np.array_equal(pulling, pulled.force.displacement)


def test_stopped_run_is_resumed_to_the_same_bits(
    pulled: kf.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, left = tmp_path / "knot", {"asked": 100}

    def due(self: StopRequest) -> bool:
        left["asked"] -= 1
        return left["asked"] < 0

    with monkeypatch.context() as patch:
        patch.setattr(StopRequest, "due", property(due))
        with pytest.raises(kf.Stopped, match="go on with knotfem resume"):
            kf.pull("overhand", KNOT, out=folder)
    assert RunDirectory.open(folder).read_status()["state"] == "stopped"
    assert_same_bits(kf.resume(folder), pulled, *TABLES)
    assert_same_bits(kf.resume(folder, {"solver.threads": 2}), pulled, *TABLES)
    assert_same_bits(kf.open_run(folder), pulled, *TABLES)


def test_what_was_computed_before_an_error_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = {**KNOT, "solver.max_iterations": 1, "solver.max_cutbacks": 0}
    with pytest.raises(kf.NotConverged) as failed:
        kf.pull("overhand", failing)
    run = failed.value.run
    assert isinstance(run, kf.Run)
    assert list(run.cost.phases) == ["mapping", "relax"]
    assert run.table("tie")["mapping_time"].tolist() == [1.0]
    asked: list[str] = []
    monkeypatch.setattr(KnotMonitor, "lost", lambda *knots: asked.append("") or "")
    kf.pull("overhand", KNOT)
    said = iter([*asked[:-2], "the 3_1 of rod has come undone"])
    monkeypatch.setattr(KnotMonitor, "lost", lambda *knots: next(said))
    with pytest.raises(kf.KnotLost, match="pull: the 3_1 of rod has come undone") as lost:
        kf.pull("overhand", KNOT)
    run = lost.value.run
    assert isinstance(run, kf.Run)
    assert run.force.displacement[-1] == run.tension().displacement == 1.5


def test_time_limit_and_interrupt_end_a_run_in_memory_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(kf.Stopped, match="the time limit is reached; the error's attribute `run`") as stopped:
        kf.pull("overhand", {**KNOT, "solver.time_limit": "0.01 s"})
    assert isinstance(stopped.value.run, kf.Run)
    monkeypatch.setattr(StopRequest, "due", True)
    monkeypatch.setattr(StopRequest, "error", lambda self, kept: kf.Interrupted(f"interrupted; {kept}"))
    with pytest.raises(kf.Interrupted, match="results so far"):
        kf.pull("overhand", KNOT)


class Spring(kf.Term):
    """A spring between a node and a point."""

    name, role, external = "spring", kf.Role.FIELD, True

    def __init__(self, node: int, point: np.ndarray, stiffness: float) -> None:
        self.node, self.point, self.stiffness = node, point, stiffness

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        residual[self.node, :3] += self.stiffness * (x[self.node, :3] - self.point)
        if matrix is not None:
            diagonal = np.zeros_like(x)
            diagonal[self.node, :3] = self.stiffness
            matrix.add_diagonal(diagonal.ravel())
        return True

    def energy(self, x: np.ndarray) -> float:
        return 0.5 * self.stiffness * float(np.sum((x[self.node, :3] - self.point) ** 2))

    def merit(self, x: np.ndarray) -> float:
        return self.energy(x)


PULL = {
    "kind": "pull", "name": "draw", "displacement": "8 mm",
    "ends": {"rod": {"end": {"motion": "driven", "direction": [0.0, 0.0, 1.0]}}},
}  # fmt: skip
DRAWN = {**BEAM, "gravity": None, "rods.0.core": None, "solver.move_over_diameter": 0.1, "steps": [PULL]}
"""A clamped rod whose other end is driven sideways."""
SOLID = {**DRAWN, "model": "fem", "rods.0.mesh.section_elements": 4, "tie.increments": 1}


@pytest.mark.parametrize("scene", [DRAWN, SOLID], ids=["rod", "fem"])
def test_term_of_ones_own_acts_and_is_in_the_energy_balance(scene: dict[str, object], tmp_path: Path) -> None:
    stiffness, made = 2e-3, []

    def spring(model: Model) -> Spring:
        """It holds the middle of the rod where it is at first."""
        nodes, places = model.axis_nodes(0), model.targets[0].points
        made.append(Spring(int(nodes[nodes.size // 2]), places[nodes.size // 2], stiffness))
        return made[-1]

    plain = kf.pull("cantilever", scene)
    run = kf.pull("cantilever", scene, terms=[spring])
    assert "spring" not in plain.energy.names
    assert run.force.force[-1] > plain.force.force[-1] + 1e-4
    profile = run.tension().table
    middle = np.array([profile[f"{axis}_mm"][profile["s_over_L"] == 0.5][0] for axis in "xyz"])
    stretched = middle - made[-1].point
    kept = 0.5 * stiffness * float(stretched @ stretched)
    assert run.energy["spring"][-1] == pytest.approx(kept, rel=1e-9)
    work = run.energy["work"][-1]
    assert kept > 0.05 * work
    assert abs(run.energy["missing"][-1]) < 0.01 * work
    assert run.summary["energies_Nmm"]["stored_by"] == {"spring": pytest.approx(kept)}
    assert run.cost.effects["spring"] > 0.0
    assert run.table("force")["imbalance_N"][-1] < 1e-3 * run.force.force[-1]
    again = kf.pull("cantilever", scene, terms=[made[-1]], out=tmp_path / "run")
    assert_same_bits(run, again, "force", "tension")


class Sphere:
    """A rigid ball."""

    def __init__(self, centre: np.ndarray, radius: float) -> None:
        self.centre, self.radius = centre, radius

    def distance(self, points: np.ndarray) -> np.ndarray:
        return np.linalg.norm(points - self.centre, axis=1) - self.radius

    def foot(self, points: np.ndarray) -> kf.Foot:
        across = points - self.centre
        rho = np.linalg.norm(across, axis=1)
        normal = across / rho[:, None]
        turn = (np.eye(3) - normal[:, :, None] * normal[:, None]) / rho[:, None, None]
        return kf.Foot(rho - self.radius, normal, turn)


@pytest.mark.parametrize("scene", [DRAWN, SOLID], ids=["rod", "fem"])
def test_obstacle_of_ones_own_stands_in_the_way(scene: dict[str, object]) -> None:
    touching = {**scene, "contact.enabled": True}
    plain = kf.pull("cantilever", touching)
    ball = Sphere(np.array([20.0, 0.0, 9.0]), 4.5)
    run = kf.pull("cantilever", touching, obstacles=[kf.Obstacle(ball, friction=0.2, name="ball")])
    assert run.force.force[-1] > 1.2 * plain.force.force[-1]
    found = run.contacts()
    assert set(found["other"]) == {"ball"}
    assert np.abs(found["arclength_mm"] - 60.0).max() < 4.0
    assert 0.0 < run.summary["max_penetration_over_d"] < 0.05
    assert {"obstacle", "obstacle friction"} <= set(run.summary["effects"])
    assert abs(run.energy["missing"][-1]) < 0.02 * run.energy["work"][-1]
    with pytest.raises(kf.InputError, match="obstacles need contact"):
        kf.pull("cantilever", scene, obstacles=[kf.Obstacle(ball)])


class Stiffer(kf.Material):
    """Neo-Hooke of twice the scene's shear modulus."""

    def energy(self, invariant: np.ndarray) -> np.ndarray:
        return 0.475 * (invariant - 3.0)

    def first(self, invariant: np.ndarray) -> np.ndarray:
        return np.full_like(invariant, 0.475)

    def second(self, invariant: np.ndarray) -> np.ndarray:
        return np.zeros_like(invariant)


def test_material_of_ones_own_is_that_of_the_rod() -> None:
    plain, run = (kf.pull("cantilever", SOLID, materials=laws) for laws in (None, {"rod": Stiffer()}))
    assert run.force.force[-1] == pytest.approx(2.0 * plain.force.force[-1], rel=0.05)


def test_runs_are_compared(pulled: kf.Run, stored: kf.Run) -> None:
    assert stored.path is not None
    found = {figure.name: list(figure.cells) for figure in kf.compare(pulled, stored.path).figures}
    assert found["force curve, L2 difference"] == [None, 0.0]
    assert [curve.label for curve in kf.compare(pulled, stored).curves] == ["overhand", "knot"]


def test_progress_is_told_and_closed() -> None:
    told: list[str] = []

    class Told:
        def message(self, text: str) -> None:
            told.append(text)

        def step(self, report: object) -> None:
            told.append("step")

        def close(self) -> None:
            told.append("closed")

    run = kf.pull("cantilever", DRAWN, progress=Told())
    assert told.count("step") == run.summary["steps"] + len(run.table("tie")["mapping_time"])
    assert told[-1] == "closed"


def test_the_library_prints_nothing_and_logs_its_steps(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    with caplog.at_level(logging.INFO, logger="knotfem"):
        run = kf.pull("cantilever", DRAWN)
        kf.pull("cantilever", DRAWN, out=tmp_path / "run")
        kf.resume(tmp_path / "run")
        with pytest.raises(kf.InputError):
            kf.pull("cantileve")
        kf.check("cantilever", BEAM)
        kf.compare(run, tmp_path / "run")
    assert capfd.readouterr() == ("", "")
    texts = [record.getMessage() for record in caplog.records]
    assert any(text.startswith("draw ") for text in texts)
    assert f"run directory {tmp_path / 'run'}" in texts
    assert "nothing is left to do" in texts


def test_importing_loads_nothing_heavy() -> None:
    program = """
import sys
import knotfem as kf
assert dir(kf) and kf.__version__
print(*sorted({"numpy", "numba", "scipy", "pydantic", "pint", "h5py", "matplotlib", "pyvista"} & set(sys.modules)))
print(*sorted(name for name in sys.modules if name.startswith("knotfem.")))
kf.load_scene("cantilever")
print("numba" in sys.modules)
assert callable(kf.pull) and callable(kf.tie) and callable(kf.tie)
from knotfem.tie import make_path
assert callable(kf.tie) and kf.tie is not sys.modules["knotfem.tie"]
print("numba" in sys.modules)
"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert found.stdout.splitlines() == ["", "knotfem.version", "False", "True"]


def test_everything_that_is_offered_is_there() -> None:
    assert all(getattr(kf, name) is not None for name in kf.__all__)
    with pytest.raises(AttributeError, match="no attribute 'push'"):
        _ = kf.push


def test_a_force_outside_the_curve_is_refused():
    run = kf.pull("crossed-rods", {"model": "rod", "steps.pull.displacement": "1 mm", "output.fields": False})
    with pytest.raises(kf.InputError, match="outside the curve"):
        run.force.at(1.5)
    with pytest.raises(kf.InputError, match="outside the curve"):
        run.force.at(np.array([0.5, np.nan]))
    assert run.force.at("1 mm") == run.force.at(1.0) == run.force.force[-1]
    assert "crossed-rods" in repr(run.force)
    assert len(repr(run.tension())) < 120


class Nothing(kf.Term):
    """Forgets what `assemble` returns."""

    name, role = "nothing", kf.Role.LOAD

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> Any:
        """See `knotfem.Term`."""


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        (Nothing(), "terms: not a list"),
        ("x", "terms: not a list"),
        (["x"], "terms: no term"),
        ([None], "terms: no term"),
        ([Nothing], "terms: no term"),
        ([lambda model: 3.0], "terms: no term"),
        ([Nothing()], "terms: assemble returns nothing"),
    ],
)
def test_what_is_no_term_is_refused(terms, message):
    with pytest.raises(kf.InputError, match=message):
        kf.pull("cantilever", {"model": "rod", "output.fields": False}, terms=terms)
