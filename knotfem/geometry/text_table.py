"""Points in tables of text: commas, semicolons, tabs or blanks between the numbers, with or without a header."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.polyline import Polyline, polyline

AXES = ("x", "y", "z")
RADII = ("radius", "r")
"""Names of a column with the radius of the rod."""
_UNIT = re.compile(r"\s*[\[(].*[\])]$|(?<=[xyz])_(mm|cm|m|um|in)$")
"""What may follow the name of a column: x [mm], x (mm), x_mm."""
_PARAVIEW = {f"points{mark}{number}": axis for mark in ":_" for number, axis in enumerate(AXES)}
"""Names that ParaView gives to the columns of coordinates."""


def read_table(path: Path, text: str) -> list[Polyline]:
    """Curves of a table: a header that names the columns, or three numbers on each line; a blank line ends a curve.

    The columns are separated by semicolons, tabs, commas or blanks, whichever of them the first line has, in this
    order. Where it is not the comma, numbers may have a decimal comma. `#` begins a comment.

    Args:
        path: of the file, for messages.
        text: its content.

    Raises:
        InputError: a line that is no point; a header without x, y and z.
    """
    rows = _rows(text)
    first = next(rows, None)
    if first is None:
        return []
    separator = _separator(first[1])
    header = _cells(first[1], separator)
    plain = [_number(cell, separator) for cell in header]
    if None in plain:
        columns = [_column(cell) for cell in header]
        if not set(AXES) <= set(columns):
            raise InputError(
                f"line {first[0]} is not the header", file=path, found=first[1], expected="x,y,z among its columns"
            )
        data = list(rows)
    else:
        columns, data = list(AXES), [first, *rows]
        if len(header) != len(columns):
            found = f"{len(header)} numbers in line {first[0]}"
            raise InputError("no header", file=path, found=found, expected="x,y,z, or three numbers on each line")
    return _curves(path, data, columns, header if None in plain else columns, separator)


def _rows(text: str) -> Iterator[tuple[int, str]]:
    """Number and content of each line without comments; an empty one where a blank line stands between points."""
    blank = seen = False
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.split("#", 1)[0].strip()
        if not seen and content.lower().startswith("sep="):
            continue  # a spreadsheet says what separates its columns
        if not content:
            blank |= not line.strip()
            continue
        if blank and seen:
            yield number, ""
        yield number, content
        blank, seen = False, True


def _separator(line: str) -> str | None:
    return next((mark for mark in ";\t," if mark in line), None)


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip("\"'").strip() for cell in line.split(separator)]


def _number(cell: str, separator: str | None) -> float | None:
    try:
        return float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        return None


def _column(name: str) -> str:
    plain = _UNIT.sub("", name.strip().lower()).strip()
    return _PARAVIEW.get(plain, plain)


def _curves(
    path: Path, data: Sequence[tuple[int, str]], columns: Sequence[str], names: Sequence[str], separator: str | None
) -> list[Polyline]:
    """Curves of the lines after the header."""
    places = [columns.index(axis) for axis in AXES]
    radius = next((columns.index(name) for name in RADII if name in columns), None)
    unused = tuple(name for i, name in enumerate(names) if i not in (*places, radius))
    found: list[tuple[list[int], list[list[float]]]] = [([], [])]
    for number, content in data:
        if not content:
            if found[-1][0]:
                found.append(([], []))
            continue
        cells = _cells(content, separator)
        if [_column(cell) for cell in cells] == columns:
            continue  # the header again, above another curve
        numbers = [_number(cell, separator) for cell in cells]
        needed = [numbers[i] for i in (*places, *([] if radius is None else [radius])) if i < len(numbers)]
        if len(numbers) != len(columns) or None in needed:
            expected = f"{len(columns)} numbers {','.join(names)}"
            raise InputError(f"line {number} is not a point", file=path, found=content, expected=expected)
        found[-1][0].append(number)
        found[-1][1].append([value for value in needed if value is not None])
    curves = []
    for lines, values in found:
        array = np.array(values, dtype=np.float64).reshape(-1, 3 if radius is None else 4)
        curve = polyline(np.ascontiguousarray(array[:, :3]), np.array(lines, dtype=np.int64))
        curves.append(replace(curve, radii=None if radius is None else array[:, 3], unused=unused))
    return curves
