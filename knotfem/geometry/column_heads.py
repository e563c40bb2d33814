"""Heads of the columns of curve files: names of the columns and units of length."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from knotfem.errors import InputError
from knotfem.geometry.length_units import LengthUnit, length_unit

AXES = ("x", "y", "z")
RADII = ("radius", "r")
"""Names of a column with the radius of the rod."""
_BRACKETS = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]")
_SUFFIX = re.compile(r"(?P<name>.*?)(?:_|\s*/\s*|\s+)(?P<unit>[^_/\s]+)")
"""What may follow the name of a column: x [mm], x (mm); x_mm, x/mm, x mm."""
_PARAVIEW = {f"points{mark}{number}": axis for mark in ":_" for number, axis in enumerate(AXES)}
"""Names that ParaView gives to the columns of coordinates."""


@dataclass(frozen=True)
class ColumnHead:
    """Head of a column.

    Attributes:
        text: as it stands in the file.
        name: in small letters, without the unit.
        unit: of its numbers, or None.
        unknown: a unit that is none of length, or nothing.
    """

    text: str
    name: str
    unit: LengthUnit | None = None
    unknown: str = ""


def column_heads(texts: Sequence[str]) -> list[ColumnHead]:
    """Heads of columns; where x, y and z are missing otherwise, a unit behind them may be one that is not known."""
    found = [column_head(text) for text in texts]
    if has_axes(found):
        return found
    others = [_with_unknown_unit(head) for head in found]
    return others if has_axes(others) else found


def has_axes(columns: Sequence[ColumnHead]) -> bool:
    """Whether x, y and z are among columns."""
    return set(AXES) <= {column.name for column in columns}


def _with_unknown_unit(head: ColumnHead) -> ColumnHead:
    """An axis with a suffix that is no unit of length, such as x_kg."""
    suffix = _SUFFIX.fullmatch(head.name)
    if suffix is None or suffix["name"] not in AXES:
        return head
    return replace(head, name=suffix["name"], unknown=suffix["unit"])


def column_head(text: str) -> ColumnHead:
    """The head of a column; a suffix counts as a unit only if it is one of length."""
    plain = text.strip().lower()
    bracket, suffix = _BRACKETS.fullmatch(plain), _SUFFIX.fullmatch(plain)
    unit, unknown = None, ""
    if bracket is not None:
        plain, unit = bracket["name"], length_unit(bracket["unit"])
        unknown = "" if unit is not None else bracket["unit"]
    elif suffix is not None and (unit := length_unit(suffix["unit"])) is not None:
        plain = suffix["name"]
    return ColumnHead(text, _PARAVIEW.get(plain, plain), unit, unknown)


def shared_unit(path: Path, axes: Sequence[ColumnHead]) -> ColumnHead:
    """The column whose unit x, y and z share; the first where there is none.

    Raises:
        InputError: they have several.
    """
    given = [column for column in axes if column.unit is not None]
    for column in given[1:]:
        if column.unit != given[0].unit:
            found = " and ".join(f'"{one.text}"' for one in (given[0], column))
            raise InputError("two units in its header", file=path, found=found, expected="one for x, y and z")
    return given[0] if given else axes[0]
