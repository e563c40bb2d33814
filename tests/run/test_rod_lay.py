"""Rods laid into the knot: free of twist, or with the twist that a tied run's clamped ends hold."""

from pathlib import Path

import numpy as np
import pytest

from knotfem.centerline.frames import rotation_minimising_frame, turn_frames
from knotfem.errors import InputError
from knotfem.rod.ends import clamped
from knotfem.rod.model import RodModel
from knotfem.run.build import centreline_of, mesh_of
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.rod_build import rod_spec
from knotfem.run.rod_lay import LaidRod, lay
from knotfem.scene import Scene, load_scene
from knotfem.solver.schemes import Scheme as QuasiStatic
from knotfem.tie import swept_state

COARSE = ("rods.0.mesh.section_elements=4", "rods.0.mesh.element_length=8 mm")
TURN = 4.0


def twists(laid: LaidRod) -> np.ndarray:
    """Twist per length at the start's clamp, at the inner nodes and at the end's clamp."""
    model = RodModel([rod_spec(laid)], scheme=QuasiStatic())
    model.begin({(0, side): clamped(frame) for side, frame in zip(("start", "end"), laid.ends, strict=True)})
    per_length = model.frames.twists(model.x) / model.frames.cell
    return np.concatenate([per_length[-2:-1], per_length[:-2], per_length[-1:]])


@pytest.fixture(scope="module")
def tied(tmp_path_factory: pytest.TempPathFactory) -> RunDirectory:
    """A run whose sections lie along the bowline and turn unevenly by TURN in all."""
    scene = load_scene("bowline", COARSE)
    run = RunDirectory.create(scene, tmp_path_factory.mktemp("lay") / "solid")
    rod = scene.rods[0]
    mesh, points = mesh_of(rod), centreline_of(rod, rod.slices, scene).points
    frames = turn_frames(rotation_minimising_frame(points), TURN * np.linspace(0.0, 1.0, rod.slices + 1) ** 2)
    x = np.empty((len(mesh.nodes), 3))
    x[mesh.section_nodes] = swept_state(points, frames, mesh.nodes[mesh.section_nodes[0], :2], 0.0)
    run.checkpoints.save({"progress": {"motion": {"x": x}}}, {}, name=TIED)
    return run


def light(source: Path | str, *overrides: str) -> Scene:
    return load_scene("bowline", [*COARSE, "model=rod", f'tie.source="{source}"', *overrides])


def test_along_a_centreline_there_is_no_twist():
    (laid,) = lay(load_scene("bowline", [*COARSE, "model=rod"]))
    edges = np.diff(laid.target.points, axis=0)
    assert np.abs(np.einsum("ji,ji->j", laid.directors, edges)).max() < 1e-12
    assert np.linalg.norm(laid.directors, axis=1) == pytest.approx(1.0)
    assert np.abs(twists(laid)).max() < 1e-12


def test_from_a_tied_run_the_ends_hold_its_twist_and_it_is_even(tied):
    (laid,) = lay(light(tied.path))
    found = twists(laid)
    assert found == pytest.approx(np.full(found.size, found[0]), abs=1e-12)
    assert 600.0 * found[0] == pytest.approx(TURN, rel=0.02)


def test_free_end_lets_the_twist_go(tied):
    (laid,) = lay(light(tied.path, 'steps.0.ends.rod.end={motion="free"}'))
    assert np.abs(twists(laid)).max() < 1e-12
    assert laid.ends[0].director == pytest.approx(lay(light(tied.path))[0].ends[0].director)


def test_only_the_end_clamped_turns_the_whole_rod(tied):
    (held,), (laid,) = lay(light(tied.path)), lay(light(tied.path, 'steps.0.ends.rod.start={motion="pinned"}'))
    assert np.abs(twists(laid)).max() < 1e-12
    assert laid.ends[1].director == pytest.approx(held.ends[1].director, abs=1e-9)


def test_other_segments_lie_on_the_same_curve(tied):
    (coarse,), (fine,) = lay(light(tied.path)), lay(light(tied.path, "rods.0.mesh.element_length=4 mm"))
    assert len(fine.directors) == 2 * len(coarse.directors)
    assert fine.target.points[::2] == pytest.approx(coarse.target.points)
    assert 600.0 * twists(fine)[0] == pytest.approx(TURN, rel=0.02)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("rods.0.length=610 mm", "rods: differs from the scene"),
        ("rods.0.diameter=5 mm", "rods: differs from the scene"),
        ("obstacles.0.diameter=18 mm", "obstacles: differs from the scene"),
    ],
)
def test_source_of_other_rods_or_obstacles_is_refused(tied, override, message):
    with pytest.raises(InputError, match=message):
        lay(light(tied.path, override))


def test_source_must_be_a_tied_three_dimensional_run(tied, tmp_path):
    with pytest.raises(InputError, match="no such run"):
        lay(light(tmp_path / "none"))
    RunDirectory.create(tied.scene, tmp_path / "loose")
    with pytest.raises(InputError, match="not tied yet"):
        lay(light(tmp_path / "loose"))
    RunDirectory.create(load_scene("bowline", [*COARSE, "model=rod"]), tmp_path / "rod")
    with pytest.raises(InputError, match="the source is a rod run"):
        lay(light(tmp_path / "rod"))
