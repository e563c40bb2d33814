"""The table of a study: a row a point, in memory and as study.csv."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.files import write_atomically
from knotfem.names import suggestion
from knotfem.results.base import frame_of
from knotfem.results.data import open_run
from knotfem.results.run import Run
from knotfem.run.tables import write_table
from knotfem.types import Arrays

CSV, PARQUET, RUNS = "study.csv", "study.parquet", "runs"


@dataclass(frozen=True, eq=False)
class StudyTable:
    """Results of a study, a row for each of its points.

    Attributes:
        path: folder of the study.
        columns: by name, each of shape [points]: "point", the axes' keys, "state", "verdict", "failure_mode",
            "reason" and what was collected; numbers with NaN, or text with "", where a point has none.
    """

    path: Path
    columns: Arrays

    def __len__(self) -> int:
        return len(self.columns["point"])

    def __getitem__(self, name: str) -> np.ndarray:
        """A column, shape [points].

        Raises:
            InputError: there is no such column.
        """
        try:
            return self.columns[name]
        except KeyError:
            raise InputError("no such column", key=name, expected=suggestion(name, list(self.columns))) from None

    def __repr__(self) -> str:
        states = self.columns["state"].tolist()
        counted = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        return f"<study {str(self.path)!r}, {len(self)} points: {counted}>"

    @property
    def points(self) -> list[str]:
        """Names of the points, which are those of their run directories."""
        return self.columns["point"].tolist()

    def run(self, point: str | int) -> Run:
        """The results of one point.

        Args:
            point: its name, or the number of its row.

        Raises:
            InputError: no run of it is there.
        """
        name = self.points[point] if isinstance(point, int) else point
        return open_run(self.path / RUNS / name)

    def to_pandas(self) -> Any:
        """A pandas DataFrame with the same columns.

        Raises:
            MissingDependency: pandas is not installed.
        """
        return frame_of(self.columns)

    def write(self) -> None:
        """Write study.csv, with empty cells where there is no value, and, where pyarrow is installed, study.parquet.

        Raises:
            InputError: the disk is full or the folder cannot be written.
        """
        write_table(self.path / CSV, {name: _with_blanks(values) for name, values in self.columns.items()})
        _write_parquet(self.path / PARQUET, self.columns)


def table_of(path: Path, rows: Iterable[Mapping[str, Any]], names: Iterable[str]) -> StudyTable:
    """The table of rows.

    Args:
        path: folder of the study.
        rows: values by column; None for none.
        names: of the columns, in order.
    """
    found = list(rows)
    return StudyTable(path, {name: _column(name, [row.get(name) for row in found]) for name in names})


def _column(name: str, values: list[Any]) -> np.ndarray:
    """Numbers where all are, else text."""
    known = [value for value in values if value is not None]
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in known)
    if known and numbers and name not in ("point", "state"):
        return np.array([float("nan") if value is None else value for value in values], dtype=float)
    return np.array(["" if value is None else _text(value) for value in values], dtype=str)


def _with_blanks(values: np.ndarray) -> np.ndarray:
    """Numbers as they are, but for empty text instead of NaN."""
    if values.dtype.kind != "f":
        return values
    return np.array(["" if np.isnan(value) else value for value in values.tolist()], dtype=object)


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _write_parquet(path: Path, columns: Arrays) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return
    table = pyarrow.table({name: pyarrow.array(values.tolist()) for name, values in columns.items()})
    content = pyarrow.BufferOutputStream()
    parquet.write_table(table, content)
    write_atomically(path, content.getvalue().to_pybytes())
