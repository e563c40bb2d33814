"""A run on disk: the store of a recorder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from knotfem.files import append, json_line, whole_lines, write_atomically
from knotfem.models.series import Fields, SeriesMesh
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import Table


class DiskSeries:
    """The file results.vtkhdf.

    Args:
        path: the file.
        mesh: makes its mesh.
        kept: states of an existing file that stay; None for a new one.
    """

    def __init__(self, path: Path, mesh: Callable[[], SeriesMesh], kept: int | None) -> None:
        from knotfem.run.vtkhdf import VtkHdfSeries

        if kept is not None and path.exists():
            self._series = VtkHdfSeries(path)
            self._series.truncate(kept)
            return
        made = mesh()
        self._series = VtkHdfSeries.create(path, made.reference, made.cells, point_data=made.point_data)

    def append(self, time: float, displacement: float, fields: Fields) -> None:
        """Append a state."""
        data = {"point_data": fields.point_data, "cell_data": fields.cell_data}
        self._series.append(time, fields.points, **data, displacement=displacement)

    @property
    def count(self) -> int:
        """States so far."""
        return len(self._series.times)

    def close(self) -> None:
        """Remove the working copy."""
        self._series.close()


class DiskStore:
    """Tables, series and log of a run directory.

    Args:
        run: the directory.
    """

    def __init__(self, run: RunDirectory) -> None:
        self.run = run
        self._log = run.path / "log.jsonl"

    def table(self, name: str, columns: tuple[str, ...]) -> Table:
        """The table NAME.csv."""
        return Table(self.run.path / f"{name}.csv", columns)

    def series(self, mesh: Callable[[], SeriesMesh], kept: int | None) -> DiskSeries:
        """The file results.vtkhdf."""
        return DiskSeries(self.run.path / "results.vtkhdf", mesh, kept)

    def log(self, record: Mapping[str, Any]) -> None:
        """Add a line to log.jsonl."""
        append(self._log, json_line(record))

    @property
    def logged(self) -> int:
        """Lines of log.jsonl."""
        return len(whole_lines(self._log)) if self._log.exists() else 0

    def keep_log(self, records: int) -> None:
        """Drop the lines past the first."""
        if self._log.exists():
            write_atomically(self._log, "".join(f"{line}\n" for line in whole_lines(self._log)[:records]))
