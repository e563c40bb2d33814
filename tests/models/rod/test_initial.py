"""Initial configuration of discrete rods: free of twist, or with what the clamped ends of a tied run hold."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from knotfem.errors import InputError
from knotfem.geometry.frames import rotate_frames, rotation_minimising_frame
from knotfem.models.centreline import centrelines_of
from knotfem.models.rod.initial import InitialRod, initial_rods
from knotfem.models.rod.model import RodModel
from knotfem.models.solid.body import mesh_of
from knotfem.run.checkpoint import read_checkpoint
from knotfem.run.directory import SOURCE, TIED, RunDirectory
from knotfem.run.source import source_rods
from knotfem.scene import Scene, load_scene
from knotfem.tie import swept_state

COARSE = ("rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=8 mm")
TURN = 4.0
MOVED = 7.0


def initial(scene: Scene, folder: Path | None = None) -> InitialRod:
    """The only rod of a scene, from its source if it has one."""
    (rod,) = initial_rods(scene, source_rods(scene, folder))
    return rod


def twists(scene: Scene) -> np.ndarray:
    """Twist per length of a scene's only rod: at the start's clamp, at the inner nodes and at the end's clamp."""
    model = RodModel(scene, source=source_rods(scene))
    frames, state = model.discrete.frames, model.straight()
    frames.load(state.history["frames-1"])
    per_length = frames.twists(state.x) / frames.cell
    return np.concatenate([per_length[-2:-1], per_length[:-2], per_length[-1:]])


def save(run: RunDirectory, x: np.ndarray, name: str = "") -> None:
    """What of a checkpoint matters for another run that sets out from it."""
    state = {"simulation": {"now": {"state": {"x": x}}}, "summary": {}}
    run.checkpoints.save(state, {"rows": {}}, name)


@pytest.fixture(scope="module")
def tied(tmp_path_factory: pytest.TempPathFactory) -> RunDirectory:
    """A run whose sections lie along the bowline and turn unevenly by TURN in all."""
    scene = load_scene("bowline", COARSE)
    run = RunDirectory.create(scene, tmp_path_factory.mktemp("lay") / "solid")
    rod = scene.rods[0]
    (target,) = centrelines_of(scene)
    mesh, points = mesh_of(rod, target.slices), target.points
    frames = rotate_frames(rotation_minimising_frame(points), TURN * np.linspace(0.0, 1.0, rod.slices + 1) ** 2)
    x = np.empty((len(mesh.nodes), 3))
    x[mesh.section_nodes] = swept_state(points, frames, mesh.nodes[mesh.section_nodes[0], :2], 0.0)
    save(run, x, name=TIED)
    return run


@pytest.fixture(scope="module")
def pulled(tied: RunDirectory, tmp_path_factory: pytest.TempPathFactory) -> RunDirectory:
    """The same run some way on: its rod has moved by MOVED."""
    run = RunDirectory.create(tied.scene, tmp_path_factory.mktemp("lay") / "pulled")
    path = tied.checkpoints.named(TIED)
    assert path is not None
    run.checkpoints.adopt(path)
    save(run, read_checkpoint(path).state["simulation"]["now"]["state"]["x"] + MOVED)
    return run


def light(source: Path | str, *overrides: str) -> Scene:
    return load_scene("bowline", [*COARSE, "model=rod", f'tie.source="{source}"', *overrides])


def test_along_a_centreline_there_is_no_twist():
    scene = load_scene("bowline", [*COARSE, "model=rod"])
    rod = initial(scene)
    edges = np.diff(rod.target.points, axis=0)
    assert np.abs(np.einsum("ji,ji->j", rod.directors, edges)).max() < 1e-12
    assert np.linalg.norm(rod.directors, axis=1) == pytest.approx(1.0)
    assert np.abs(twists(scene)).max() < 1e-12


def test_from_a_tied_run_the_ends_hold_its_twist_and_it_is_even(tied):
    found = twists(light(tied.path))
    assert found == pytest.approx(np.full(found.size, found[0]), abs=1e-12)
    assert 600.0 * found[0] == pytest.approx(TURN, rel=0.02)


def test_free_end_lets_the_twist_go(tied):
    free = light(tied.path, 'steps.0.ends.rod.end={motion="free"}')
    assert np.abs(twists(free)).max() < 1e-12
    assert initial(free).ends[0].director == pytest.approx(initial(light(tied.path)).ends[0].director)


def test_only_the_end_clamped_turns_the_whole_rod(tied):
    pinned = light(tied.path, 'steps.0.ends.rod.start={motion="pinned"}')
    assert np.abs(twists(pinned)).max() < 1e-12
    assert initial(pinned).ends[1].director == pytest.approx(initial(light(tied.path)).ends[1].director, abs=1e-9)


def test_other_segments_lie_on_the_same_curve(tied):
    finer = light(tied.path, "rods.0.mesh.element_length=4 mm")
    coarse, fine = initial(light(tied.path)), initial(finer)
    assert len(fine.directors) == 2 * len(coarse.directors)
    assert fine.target.points[::2] == pytest.approx(coarse.target.points)
    assert 600.0 * twists(finer)[0] == pytest.approx(TURN, rel=0.02)


def test_graded_segments_lie_on_the_same_curve_too(tied):
    graded = light(tied.path, "rods.0.mesh.turning_angle=0.3")
    coarse, rod = initial(light(tied.path)), initial(graded)
    slices = rod.target.slices
    assert slices.lengths.min() < 0.6 * slices.lengths.max()
    along = CubicSpline(coarse.target.slices.arclength, coarse.target.points)
    assert rod.target.points == pytest.approx(along(slices.arclength), abs=1e-9)
    found = twists(graded)
    assert found == pytest.approx(np.full(found.size, found[0]), abs=1e-12)
    assert 600.0 * found[0] == pytest.approx(TURN, rel=0.02)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("rods.0.length=610 mm", "rods.0.length: differs from the scene; found 600 mm; expected 610 mm"),
        ("rods.0.diameter=5 mm", "rods.0.diameter: differs from the scene; found 6 mm; expected 5 mm"),
        ("rods.0.material.youngs_modulus=3 MPa", "material.youngs_modulus: differs .* found 1.425 MPa; expected 3 MPa"),
        ("rods.0.core=none", "rods.0.core.youngs_modulus: differs .* found 75500 MPa; expected none"),
        ("obstacles.0.diameter=18 mm", "obstacles.0.diameter: differs from the scene; found 20 mm; expected 18 mm"),
        ("obstacles=[]", "obstacles.0.diameter: differs from the scene; found 20 mm; expected none"),
    ],
)
def test_source_of_other_rods_or_obstacles_is_refused(tied, override, message):
    with pytest.raises(InputError, match=message):
        initial(light(tied.path, override))


def test_source_must_be_a_tied_three_dimensional_run(tied, tmp_path):
    with pytest.raises(InputError, match="no such run"):
        initial(light(tmp_path / "none"))
    RunDirectory.create(tied.scene, tmp_path / "loose")
    with pytest.raises(InputError, match="not tied yet"):
        initial(light(tmp_path / "loose"))
    RunDirectory.create(load_scene("bowline", [*COARSE, "model=rod"]), tmp_path / "rod")
    with pytest.raises(InputError, match="the source is a rod run"):
        initial(light(tmp_path / "rod"))


def test_last_state_of_a_run_may_be_set_out_from(pulled):
    tied, last = initial(light(pulled.path)), initial(light(pulled.path, "tie.source_state=last"))
    assert last.target.points == pytest.approx(tied.target.points + MOVED)
    assert last.directors == pytest.approx(tied.directors, abs=1e-9)
    with pytest.raises(InputError, match=r'tie\.source_state: there is no source; found "last"'):
        load_scene("bowline", ["model=rod", "tie.source_state=last"])


def test_a_run_needs_its_source_only_once(tied, tmp_path):
    source = RunDirectory.create(tied.scene, tmp_path / "source")
    source.checkpoints.adopt(tied.checkpoints.named(TIED))
    scene = light(source.path)
    once = initial(scene, tmp_path)
    source.path.rename(tmp_path / "elsewhere")
    again = initial(scene, tmp_path)
    assert np.array_equal(once.target.points, again.target.points)
    assert np.array_equal(once.directors, again.directors)
    with pytest.raises(InputError, match="no such run"):
        initial(scene)
    (tmp_path / SOURCE).write_text("{}")
    with pytest.raises(InputError, match=r"source\.json: damaged"):
        initial(scene, tmp_path)


def test_source_of_an_older_version_is_refused(tied, tmp_path):
    source = RunDirectory.create(tied.scene, tmp_path / "source")
    path = source.checkpoints.save({"progress": {"motion": {"x": np.zeros(3)}}}, {}, name=TIED)
    with pytest.raises(InputError, match="the checkpoint is of an older version") as refused:
        initial(light(source.path))
    assert refused.value.file == path
