"""Files are whole or not there, even on a full disk."""

import errno
import json
import math
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.files import append, read_json, whole_lines, write_atomically, write_json


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file can grow past `size` bytes, as on a disk that fills up in the middle of a write."""
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)


def test_replaces_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_atomically(path, "one")
    write_atomically(path, b"two")
    assert path.read_text() == "two"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_full_disk_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_atomically(path, "old")
    with room_for(1000), pytest.raises(InputError, match=r"a\.txt: cannot be written"):
        write_atomically(path, "x" * 5000)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_the_message_names_the_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left on device"):
        write_atomically(tmp_path / "a.txt", "x")
    assert os.listdir(tmp_path) == []


def test_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(tmp_path / "none" / "a.txt", "x")


def test_appends_all_or_nothing(tmp_path: Path) -> None:
    path = tmp_path / "log"
    append(path, "a" * 900 + "\n")
    with room_for(1000), pytest.raises(InputError, match="cannot be written"):
        append(path, "b" * 500 + "\n")
    assert path.read_text() == "a" * 900 + "\n"
    append(path, "c\n")
    assert path.read_text() == "a" * 900 + "\nc\n"


def test_a_line_cut_short_is_no_line(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_text("one\ntwo\nthr")
    assert whole_lines(path) == ["one", "two"]
    path.write_text("thr")
    assert whole_lines(path) == []


def test_json_holds_what_numerics_give(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_json(path, {"a": np.float64(0.1), "b": np.arange(3), "c": math.nan, "d": path, "e": {"f": (1, math.inf)}})
    expected = {"a": 0.1, "b": [0, 1, 2], "c": None, "d": str(path), "e": {"f": [1, None]}}
    assert read_json(path) == expected == json.loads(path.read_text())


@pytest.mark.parametrize("content", [b"{", b"[1]", b"\xff"])
def test_damaged_json(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match="JSON"):
        read_json(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_json(tmp_path / "none.json")


def test_links_stay_and_what_is_no_file_is_written_to(tmp_path):
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    target.write_text("old")
    link.symlink_to(target)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    write_atomically(Path("/dev/null"), "gone")
    assert not Path("/dev/null").is_file()
