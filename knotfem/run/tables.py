"""CSV tables of a run: rows reach the disk whole, and a resumed run drops those past its checkpoint."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from knotfem.errors import InputError, cannot_read, cannot_write
from knotfem.files import append, whole_lines, write_atomically
from knotfem.run.columns import TEXT_COLUMNS, Value


class Table:
    """A CSV file with a header line and rows that are only ever appended or dropped from the end.

    Numbers are written so that reading gives the identical number back.

    Attributes:
        path: the file.
        columns: names, units included.
        rows: how many there are.
    """

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        """Open a table, or start it with its header.

        Args:
            path: the file.
            columns: must equal those of a file that is there and has rows.

        Raises:
            InputError: a file with other columns is there, or nothing can be written.
        """
        self.path, self.columns = path, tuple(columns)
        if path.exists():
            lines = _lines(path)
            if lines and next(csv.reader(lines[:1])) != list(columns):
                if len(lines) > 1:
                    problem = "other columns than this run writes"
                    raise InputError(problem, file=path, found=lines[0], expected=",".join(columns))
                write_atomically(path, _text([self.columns]))
            self.rows = max(len(lines) - 1, 0)
            self.keep(self.rows)
        else:
            self.rows = 0
            write_atomically(path, _text([self.columns]))

    def append(self, row: Mapping[str, Value]) -> None:
        """Append one row."""
        self.extend([row])

    def extend(self, rows: Iterable[Mapping[str, Value]]) -> None:
        """Append rows: all of them or, when the disk is full, none.

        Args:
            rows: each with a value for every column.

        Raises:
            KeyError: a column is missing or unknown; a programming error.
            InputError: the disk is full.
        """
        complete = [self._values(row) for row in rows]
        append(self.path, _text(complete))
        self.rows += len(complete)

    def keep(self, rows: int) -> None:
        """Drop all rows past the first `rows`, and what a crash may have left of another.

        Raises:
            InputError: the file has fewer rows.
        """
        lines = _lines(self.path)
        if max(len(lines) - 1, 0) < rows:
            raise InputError(
                "rows are missing", file=self.path, found=max(len(lines) - 1, 0), expected=f"at least {rows}"
            )
        text = "".join(f"{line}\n" for line in lines[: rows + 1]) or _text([self.columns])
        try:
            if text.encode() != self.path.read_bytes():
                write_atomically(self.path, text)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        self.rows = rows

    def _values(self, row: Mapping[str, Value]) -> list[Value]:
        unknown = set(row) - set(self.columns)
        if unknown:
            raise KeyError(f"{self.path.name} has no column {', '.join(sorted(unknown))}")
        return [row[column] for column in self.columns]


def read_table(path: Path, columns: Sequence[str] = ()) -> dict[str, np.ndarray]:
    """Read a CSV table.

    Args:
        path: the file.
        columns: that it must have.

    Returns:
        Columns by name, each of shape [rows]: text in `TEXT_COLUMNS`, where a cell is no number and where all are
        empty, else floats, NaN for empty cells.

    Raises:
        InputError: missing, empty or damaged.
    """
    lines = _lines(path)
    if not lines:
        raise InputError("no table: the file is empty", file=path)
    header, *rows = csv.reader(lines)
    for column in columns:
        if column not in header:
            raise InputError("no such column", file=path, key=column, found=",".join(header))
    for number, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise InputError(
                "a damaged table",
                file=path,
                key=f"line {number}",
                found=f"{len(row)} fields",
                expected=str(len(header)),
            )
    return {name: _column(name, [row[index] for row in rows]) for index, name in enumerate(header)}


def write_table(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write a whole CSV table.

    Args:
        path: the file.
        columns: by name, each of shape [rows].

    Raises:
        InputError: nothing can be written there.
    """
    write_atomically(path, table_text(columns))


def table_text(columns: Mapping[str, np.ndarray]) -> str:
    """The CSV text of a whole table; see `write_table`."""
    values = [np.asarray(column).tolist() for column in columns.values()]
    return _text([list(columns), *zip(*values, strict=True)])


def _column(name: str, cells: list[str]) -> np.ndarray:
    if name in TEXT_COLUMNS or not any(cells):
        return np.array(cells, dtype=str)
    try:
        return np.array([float(cell or "nan") for cell in cells])
    except ValueError:
        return np.array(cells)


def _lines(path: Path) -> list[str]:
    try:
        return whole_lines(path)
    except OSError as error:
        raise cannot_read(path, error) from None
    except UnicodeDecodeError:
        raise InputError("not a text file", file=path) from None


def _text(rows: Iterable[Sequence[Value]]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows([_plain(value) for value in row] for row in rows)
    return buffer.getvalue()


def _plain(value: Value) -> Value:
    """A Python number, whose text is the shortest that reads back as the same one."""
    return value.item() if isinstance(value, np.generic) else value
