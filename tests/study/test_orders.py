"""Run directories that travel: whole, nothing outside, the newest checkpoint is the one that was sent."""

from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest

from knotfem.errors import InputError
from knotfem.study.engine import orders
from knotfem.study.engine.orders import pack, unpack


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def files_of(folder: Path) -> dict[str, str]:
    return {p.relative_to(folder).as_posix(): p.read_text() for p in folder.rglob("*") if p.is_file()}


def test_run_comes_back_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {"scene.toml": "s", "status.json": "{}", "checkpoints/checkpoint-000002.h5": "h", "force.csv": "f"}
    write(tmp_path / "there", {**files, ".force.csv.1.part": "half", ".lock": "", "results.vtkhdf": "long"})
    monkeypatch.setattr(orders, "LARGEST_FILE", 3)
    write(tmp_path / "here", {"scene.toml": "old", "checkpoints/checkpoint-000009.h5": "left by a killed session"})
    unpack(pack(tmp_path / "there"), tmp_path / "here")
    assert files_of(tmp_path / "here") == files


def test_what_says_that_a_run_is_whole_is_written_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "there", dict.fromkeys(("a.csv", "scene.toml", "status.json", "summary.json", "tie.csv"), "x"))
    written: list[str] = []
    monkeypatch.setattr(orders, "write_atomically", lambda path, content: written.append(path.name))
    unpack(pack(tmp_path / "there"), tmp_path / "here")
    assert written == ["a.csv", "summary.json", "tie.csv", "status.json", "scene.toml"]


@pytest.mark.parametrize("name", ["../out", "/tmp/out", "a/../../out"])
def test_nothing_is_written_outside(tmp_path: Path, name: str) -> None:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as archive:
        archive.addfile(tarfile.TarInfo(name), io.BytesIO())
    with pytest.raises(InputError, match="no file of a run directory"):
        unpack(buffer.getvalue(), tmp_path / "here")
    assert not (tmp_path / "here").exists()
