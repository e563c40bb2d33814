"""Points in tables of text: commas, semicolons, tabs or blanks between the numbers, with or without a header."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.geometry.column_heads import AXES, RADII, ColumnHead, column_heads, has_axes, shared_unit
from knotfem.geometry.polyline import Polyline, polyline


def read_table(path: Path, text: str) -> list[Polyline]:
    """Curves of a table: a header that names the columns, or three numbers on each line; a blank line ends a curve.

    The columns are separated by semicolons, tabs, commas or blanks, whichever of them the first line has, in this
    order. Where it is not the comma, numbers may have a decimal comma. `#` begins a comment; the header may stand in
    one. Names of columns may have a unit, which x, y and z share.

    Args:
        path: of the file, for messages.
        text: its content.

    Raises:
        InputError: a line that is no point; a header without x, y and z, or with several units of theirs.
    """
    rows = _rows(text)
    first = next(rows, None)
    if first is None:
        return []
    separator = _separator(first[1])
    cells = _cells(first[1], separator)
    if None in [_number(cell, separator) for cell in cells]:
        columns = column_heads(cells)
        if not has_axes(columns):
            raise InputError(
                f"line {first[0]} is not the header", file=path, found=first[1], expected="x,y,z among its columns"
            )
        data = list(rows)
    else:
        columns, data = _commented(text, first[0], separator, len(cells)), [first, *rows]
        if len(cells) != len(columns):
            found = f"{len(cells)} numbers in line {first[0]}"
            raise InputError("no header", file=path, found=found, expected="x,y,z, or three numbers on each line")
    return _curves(path, data, columns, separator)


def _commented(text: str, first: int, separator: str | None, count: int) -> list[ColumnHead]:
    """The header in a comment above the first point, as many programs write it; x, y, z where there is none."""
    for line in reversed(text.splitlines()[: first - 1]):
        columns = column_heads(_cells(line.strip().lstrip("#").strip(), separator))
        if len(columns) == count and has_axes(columns):
            return columns
    return [ColumnHead(axis, axis) for axis in AXES]


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
    if separator is None:
        line = re.sub(r"\s+(?=[\[(])", "", line)  # a unit in brackets belongs to the name before it
    return [cell.strip().strip("\"'").strip() for cell in line.split(separator)]


def _number(cell: str, separator: str | None) -> float | None:
    try:
        return float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        return None


def _curves(
    path: Path, data: Sequence[tuple[int, str]], columns: Sequence[ColumnHead], separator: str | None
) -> list[Polyline]:
    """Curves of the lines after the header."""
    names = [column.name for column in columns]
    places = [names.index(axis) for axis in AXES]
    radius = next((names.index(name) for name in RADII if name in names), None)
    axes = [columns[i] for i in places]
    with_unit = shared_unit(path, axes)
    found: list[tuple[list[int], list[list[float]]]] = [([], [])]
    for number, content in data:
        if not content:
            if found[-1][0]:
                found.append(([], []))
            continue
        cells = _cells(content, separator)
        if [column.name for column in column_heads(cells)] == names:
            continue  # the header again, above another curve
        numbers = [_number(cell, separator) for cell in cells]
        needed = [numbers[i] for i in (*places, *([] if radius is None else [radius])) if i < len(numbers)]
        if len(numbers) != len(columns) or None in needed:
            expected = f"{len(columns)} numbers {','.join(column.text for column in columns)}"
            raise InputError(f"line {number} is not a point", file=path, found=content, expected=expected)
        found[-1][0].append(number)
        found[-1][1].append([value for value in needed if value is not None])
    curves = []
    for lines, values in found:
        array = np.array(values, dtype=np.float64).reshape(-1, 3 if radius is None else 4)
        curve = polyline(np.ascontiguousarray(array[:, :3]), np.array(lines, dtype=np.int64))
        curves.append(
            replace(
                curve,
                unit=with_unit.unit,
                unit_from=with_unit.text if with_unit.unit is not None else "",
                radii=None if radius is None else array[:, 3],
                radius_unit=None if radius is None else columns[radius].unit,
                unused=tuple(column.text for i, column in enumerate(columns) if i not in (*places, radius)),
                unknown_unit=next((column.text for column in axes if column.unknown), ""),
            )
        )
    return curves
