"""What a worker is told and what it answers; values that travel, without anything heavy."""

from __future__ import annotations

import io
import os
import tarfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from knotfem.errors import InputError
from knotfem.files import PART_SUFFIX, write_atomically

LARGEST_FILE = 64e6
"""Bytes of the largest file that travels through the scheduler; larger time series stay behind."""
_LAST, _SERIES = ("status.json", "scene.toml"), "results.vtkhdf"
"""Files that say that the others are there are written last."""


@dataclass(frozen=True)
class Order:
    """A run to bring to its goal.

    Attributes:
        folder: run directory, as the client sees it.
        study: token of the session that asks for it.
        marker: file in the study's folder that holds the token; who reads it there shares the disk.
        goal: "tie" or "pull".
        threads: of a run.
        version: of knotfem; results of another one are not the same.
        time_limit: wall time after which the run stops with a checkpoint [s], or none.
        files: the run directory, for a worker that does not share the disk; see `pack`.
    """

    folder: str
    study: str
    marker: str
    goal: str
    threads: int
    version: str
    time_limit: float | None = None
    files: bytes | None = None


@dataclass(frozen=True)
class Reply:
    """What came of an order.

    Attributes:
        state: "done", "failed", "crashed"; "stopped" at the time limit, "asked" to stop; "unseen" where the worker sees
            neither the disk nor files; "refused" where it cannot serve at all.
        reason: why it is not done.
        exit_code: of a failed run.
        worker: address.
        wall_s: wall time of this session of the run [s].
        cpu_s: CPU time likewise [s].
        files: the run directory of a worker that does not share the disk.
    """

    state: Literal["done", "failed", "crashed", "stopped", "asked", "unseen", "refused"]
    reason: str = ""
    exit_code: int = 0
    worker: str = ""
    wall_s: float = 0.0
    cpu_s: float = 0.0
    files: bytes | None = None


def pack(folder: Path) -> bytes:
    """A run directory as one archive, without unfinished files and without time series above `LARGEST_FILE`."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz", compresslevel=1) as archive:
        for path in sorted(folder.rglob("*")):
            whole = path.is_file() and not path.is_symlink() and not path.name.endswith((PART_SUFFIX, ".lock"))
            if whole and not (path.name == _SERIES and path.stat().st_size > LARGEST_FILE):
                archive.add(path, arcname=path.relative_to(folder).as_posix(), recursive=False)
    return buffer.getvalue()


def unpack(files: bytes, folder: Path) -> None:
    """Write the files of `pack`, each whole or not at all, and last those that say that the others are there.

    Checkpoints that the archive does not hold are removed: the newest must be the one that the run goes on from.

    Raises:
        InputError: the archive has a name that leads out of the folder, or the disk cannot be written.
    """
    found: dict[str, bytes] = {}
    with tarfile.open(fileobj=io.BytesIO(files), mode="r:gz") as archive:
        for member in archive:
            content = archive.extractfile(member) if member.isfile() else None
            if content is None or os.path.isabs(member.name) or ".." in Path(member.name).parts:
                raise InputError("no file of a run directory", file=folder, found=member.name)
            found[member.name] = content.read()
    for name in sorted(found, key=lambda name: _LAST.index(name) if name in _LAST else -1):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, found[name])
    for old in (folder / "checkpoints").glob("*.h5"):
        if f"checkpoints/{old.name}" not in found:
            old.unlink(missing_ok=True)
