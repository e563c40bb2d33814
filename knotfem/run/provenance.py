"""What made a run: versions, linear solver, threads, seed, start, end, exit reason."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from knotfem.errors import InputError
from knotfem.files import read_json, write_json
from knotfem.version import __version__

DAMAGED_SUFFIX = ".damaged.json"
"""Of a file that was set aside."""
LIBRARIES = (
    "numpy",
    "scipy",
    "numba",
    "scikit-fem",
    "h5py",
    "pydantic",
    "pint",
    "click",
    "gmsh",
    "meshio",
    "pyvista",
    "vtk",
    "mkl",
    "dask",
    "distributed",
)


def library_versions() -> dict[str, str]:
    """Versions of Python and of the installed libraries that knotfem builds on."""
    found = {"knotfem": __version__, "python": platform.python_version()}
    for library in LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            continue
    return found


class Provenance:
    """The file provenance.json of a run; a resumed run adds a session to it.

    The newest session stands at the top level too, with the start of the first one. A damaged file is set aside when a
    session begins.

    Attributes:
        damaged: whether the file cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        """Read what earlier sessions left.

        Args:
            folder: the run directory.
        """
        self._path = folder / "provenance.json"
        self.damaged = False
        self._sessions: list[dict[str, Any]] = self._read() if self._path.exists() else []

    def _read(self) -> list[dict[str, Any]]:
        try:
            sessions = read_json(self._path)["sessions"]
            return [dict(session) for session in sessions]
        except (InputError, KeyError, TypeError, ValueError):
            self.damaged = True
            return []

    @property
    def additions(self) -> dict[str, list[str]] | None:
        """Names of what the user added to the last session as objects; None where there is no session that says so."""
        return self._sessions[-1].get("additions") if self._sessions else None

    def begin(self, *, threads: int, additions: Mapping[str, Sequence[str]]) -> None:
        """Start a session.

        The linear solver is noted once it is known. The seed is null: no run draws what another seed would change.

        Args:
            threads: in use.
            additions: names of what the user adds as objects, by kind.
        """
        if self.damaged:
            with suppress(OSError):
                self._path.replace(self._path.with_suffix(DAMAGED_SUFFIX))
        self._sessions.append(
            {
                "command": list(sys.argv),
                "platform": platform.platform(),
                "machine": platform.machine(),
                "processors": os.cpu_count(),
                "versions": library_versions(),
                "linear_solver": None,
                "threads": threads,
                "additions": additions,
                "seed": None,
                "start": timestamp(),
                "end": None,
                "exit_reason": None,
            }
        )
        self._write()

    def note(self, **facts: Any) -> None:
        """Record facts of the running session, such as linear_solver="pardiso"."""
        self._sessions[-1].update(facts)
        self._write()

    def finish(self, exit_reason: str) -> None:
        """End the session.

        Args:
            exit_reason: "done", or what ended the run.
        """
        self.note(end=timestamp(), exit_reason=exit_reason)

    def _write(self) -> None:
        newest = {**self._sessions[-1], "start": self._sessions[0]["start"]}
        write_json(self._path, {**newest, "sessions": self._sessions})


def timestamp() -> str:
    """Date and time in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")
