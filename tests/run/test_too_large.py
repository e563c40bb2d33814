"""What no machine can hold, and what is no file, is refused before anything is built or read."""

import os
from pathlib import Path

import pytest

import knotfem as kf
from knotfem.errors import InputError
from knotfem.run import expected
from knotfem.scene import load_scene
from knotfem.scene.load import read_toml


@pytest.mark.parametrize("way", [kf.check, lambda scene: kf.tie(scene, progress=False)])
def test_a_scene_beyond_the_memory_is_refused(way, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expected, "machine_memory_mb", lambda: 16.0 * 1024)
    scene = load_scene("bowline", ["rods.0.mesh.element_length=0.001 mm"])
    with pytest.raises(InputError, match=r"needs more memory than this machine has; found about .* GB for .* unknowns"):
        way(scene)


def test_usual_scenes_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expected, "machine_memory_mb", lambda: 2.0 * 1024)
    expected.refuse_too_large(load_scene("bowline"))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with a name")
def test_pipes_and_devices_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scene.toml")
    os.mkfifo(tmp_path / "curve.csv")
    for path in (tmp_path / "scene.toml", Path("/dev/zero")):
        with pytest.raises(InputError, match="not a regular file; found a pipe or a device"):
            load_scene(path)
    with pytest.raises(InputError, match=r"curve\.csv: not a regular file"):
        kf.check("overhand", ["model=rod", f"rods.0.centerline={tmp_path}/curve.csv"])


def test_a_file_of_any_size_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(2**30)
    with pytest.raises(InputError, match="too large a file; found 1024 MB; expected at most 64 MB"):
        read_toml(path)


def test_samples_take_memory() -> None:
    memory = [
        expected.expected(load_scene("bowline", {"contact.sample_spacing_over_diameter": spacing})).memory_mb
        for spacing in (0.125, 0.02)
    ]
    assert 300.0 < memory[1] - memory[0] < 700.0


def test_more_steps_than_anybody_writes_are_refused() -> None:
    steps = [{"kind": "hold", "duration": "1 s"}] * 10_001
    with pytest.raises(InputError, match="steps: too many; found 10,001 steps; expected at most 10,000"):
        load_scene("overhand", {"steps": steps})


@pytest.mark.parametrize("spacing", ["1e-9", "1e-5", "2.0"])
def test_samples_beyond_reason_are_refused(spacing: str) -> None:
    with pytest.raises(InputError, match="sample_spacing_over_diameter"):
        load_scene("bowline", [f"contact.sample_spacing_over_diameter={spacing}"])
