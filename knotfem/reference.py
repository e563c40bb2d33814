"""Reference of scene keys, columns and fields, made from the code: units, defaults, bounds, meaning.

`python -m knotfem.reference FOLDER` writes its pages.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic_core import PydanticUndefined

from knotfem.errors import InputError
from knotfem.files import write_atomically
from knotfem.names import suggestion
from knotfem.run.column_meanings import COLUMNS, ROWS, TABLES, unit_of_column
from knotfem.run.field_meanings import FIELDS
from knotfem.scene.model import Scene
from knotfem.scene.quantity import Quantity
from knotfem.scene.rope import quantity_of
from knotfem.scene.table import Table

GENERATED = "Made from the code by `python -m knotfem.reference docs/reference`; `knotfem help KEY` says the same."
SIGNS = {Gt: ">", Ge: ">=", Lt: "<", Le: "<="}
ENTRY = "N"
"""Stands for the number of an entry of a list."""


@dataclass(frozen=True)
class Key:
    """A key of a scene.

    Attributes:
        path: dotted, with `ENTRY` for the number or name of an entry, and the kind of a step or end in brackets.
        kind: of its value, with the unit.
        default: as a scene writes it; "required" without one.
        meaning: in words.
    """

    path: str
    kind: str
    default: str
    meaning: str

    def __str__(self) -> str:
        return f"{self.path}\n  value    {self.kind}\n  default  {self.default}\n  {self.meaning}"

    @property
    def plain(self) -> tuple[str, ...]:
        """Parts of the path without kinds and entries."""
        return _plain(self.path)


@cache
def scene_keys() -> tuple[Key, ...]:
    """All keys of a scene, in its order."""
    return tuple(_keys(Scene, ""))


def look_up(name: str) -> str:
    """What a key of a scene, a column or a field is.

    Args:
        name: such as "contact.friction", "rods.0.length", "steps.pull.speed", "friction", "unrest_N", "twist".

    Raises:
        InputError: nothing has this name.
    """
    wanted, found = _plain(name), list[str]()
    keys = [key for key in scene_keys() if key.plain[-len(wanted) :] == wanted] if wanted else []
    parts = name.split(".")
    if not keys and len(parts) > 2:  # entries of lists by their names
        keys = [key for key in scene_keys() if key.plain == (parts[0], *_plain(".".join(parts[2:])))]
    found += [f"key of a scene: {key}" for key in keys]
    tables = [table for table, columns in TABLES.items() if name in columns]
    if tables:
        unit = unit_of_column(name)
        files = ", ".join(f"{table}.csv" for table in tables)
        found.append(f"column of {files}: {name}\n  {COLUMNS[name]}{f' [{unit}]' if unit else ''}")
    if name in FIELDS:
        field = FIELDS[name]
        order = f", components {field.components}" if field.components else ""
        where = f"{field.places}; model {field.models}"
        found.append(f"field of results.vtkhdf: {name}\n  {field.text} [{field.unit}]{order}\n  on {where}")
    if not found:
        known = [*dict.fromkeys([key.plain[-1] for key in scene_keys()] + [*COLUMNS, *FIELDS])]
        expected = suggestion(name.rpartition(".")[2], known).partition(", or one of")[0]
        expected = expected if expected.startswith('"') else "a key of a scene, a column or a field"
        raise InputError("nothing has this name", key="help", found=f'"{name}"', expected=expected)
    return "\n\n".join(found)


def pages() -> dict[str, str]:
    """Pages of the reference by file name."""
    return {"scene.md": _scene_page(), "tables.md": _tables_page(), "fields.md": _fields_page()}


def write_pages(folder: Path) -> None:
    """Write the pages into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        write_atomically(folder / name, text)


def _plain(path: str) -> tuple[str, ...]:
    parts = re.sub(r"\[[^]]*\]", "", path).split(".")
    same = ("centerline" if part == "centreline" else part for part in parts)
    return tuple(part for part in same if part and part != ENTRY and not part.isdecimal())


def _keys(table: type[Table], above: str) -> Iterator[Key]:
    said = meanings(table)
    for name, field in table.model_fields.items():
        annotation: Any = field.annotation
        path = f"{above}{name}"
        inner = list(_tables_in(annotation))
        default = "required" if field.is_required() else _default(field.get_default(call_default_factory=True), field)
        kind = _kind(annotation, field.metadata, inner)
        yield Key(path, kind, default, said.get(name, ""))
        place = f"{path}.{ENTRY}" if _is_list(annotation) else path
        if len(inner) == 1:
            yield from _keys(inner[0], f"{place}.")
        elif inner:
            yield from _keys_of_kinds(inner, place)


def _keys_of_kinds(tables: list[type[Table]], place: str) -> Iterator[Key]:
    """Keys of several tables of which one stands in a place: first which one, then what all have, then the others."""
    yield _choice(tables, place)
    found = [[key for key in _keys(one, "") if key.path not in ("kind", "motion")] for one in tables]
    shared = [key for key in found[0] if all(key in keys for keys in found)]
    yield from (replace(key, path=f"{place}.{key.path}") for key in shared)
    for one, keys in zip(tables, found, strict=True):
        yield from (replace(key, path=f"{place}{_tag(one)}.{key.path}") for key in keys if key not in shared)


@cache
def meanings(table: type) -> dict[str, str]:
    """What the docstrings of a class and its bases say of attributes, by name."""
    found: dict[str, str] = {}
    for kind in reversed(table.__mro__):
        text = inspect.cleandoc(kind.__dict__.get("__doc__") or "").partition("Attributes:\n")[2]
        for match in re.finditer(r"^ {4}(\w+): (.*(?:\n {8,}.*)*)", text, re.MULTILINE):
            found[match[1]] = " ".join(match[2].split())
    return found


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    """Tables that an annotation names."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for part in get_args(annotation):
        yield from _tables_in(part)


def _is_list(annotation: Any) -> bool:
    origin = get_origin(annotation)
    return origin in (tuple, dict) or any(_is_list(part) for part in get_args(annotation) if origin is not tuple)


def _tag(table: type[Table]) -> str:
    """The kind of a step or of an end, in brackets."""
    field = next((table.model_fields[key] for key in ("kind", "motion") if key in table.model_fields), None)
    names = get_args(field.annotation) if field is not None else ()
    return f"[{names[0]}]" if names else ""


def _choice(tables: list[type[Table]], path: str) -> Key:
    """The key that says which of several tables stands in a place."""
    name = next(key for key in ("kind", "motion") if key in tables[0].model_fields)
    first = tables[0].model_fields[name]
    kinds = ", ".join(f'"{_tag(table)[1:-1]}"' for table in tables)
    default = "required" if first.is_required() else _default(first.default, first)
    said = "; ".join(f"{_tag(table)[1:-1]}: {(table.__doc__ or '').splitlines()[0]}" for table in tables)
    return Key(f"{path}.{name}", kinds, default, said)


def _kind(annotation: Any, metadata: list[Any], inner: list[type[Table]]) -> str:
    if inner:
        return "list of tables" if _is_list(annotation) else "table"
    quantity = next((entry for entry in metadata if isinstance(entry, Quantity)), None) or quantity_of(annotation)
    if quantity is not None:
        return f"{quantity.what.removeprefix('an ').removeprefix('a ')} [{quantity.unit}]" + _bounds_of(quantity)
    choices = list(_choices(annotation))
    if choices:
        return ", ".join(f'"{choice}"' for choice in choices)
    names = {bool: "true or false", int: "whole number", float: "number", str: "text"}
    plain = list(_plain_types(annotation))
    if get_origin(annotation) is tuple:
        many = "" if Ellipsis in get_args(annotation) else f"{len(get_args(annotation))} "
        text = f"list of {many}" + ("lengths [mm]" if quantity_of(get_args(annotation)[0]) else "values")
    else:
        text = " or ".join(dict.fromkeys(names[kind] for kind in plain if kind in names))
    bounds = [f"{SIGNS[type(entry)]} {_limit(entry):g}" for entry in _constraints(annotation, metadata)]
    return text + (f", {' and '.join(bounds)}" if bounds else "")


def _constraints(annotation: Any, metadata: list[Any]) -> list[Any]:
    found = [entry for entry in metadata if type(entry) in SIGNS]
    for part in get_args(annotation):
        nested = getattr(part, "metadata", [])
        found += [entry for entry in nested if type(entry) in SIGNS]
        if get_origin(part) is Annotated or get_args(part):
            found += _constraints(part, [])
    return found


def _limit(entry: Any) -> float:
    return next(getattr(entry, key) for key in ("gt", "ge", "lt", "le") if hasattr(entry, key))


def _bounds_of(quantity: Quantity) -> str:
    low = [] if quantity.minimum is None else [f"{'>' if quantity.open_minimum else '>='} {quantity.minimum:g}"]
    high = [] if quantity.maximum is None else [f"<= {quantity.maximum:g}"]
    return f", {' and '.join([*low, *high])}" if low or high else ""


def _choices(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Literal:
        yield from get_args(annotation)
        return
    for part in get_args(annotation):
        yield from _choices(part)


def _plain_types(annotation: Any) -> Iterator[type]:
    if isinstance(annotation, type):
        yield annotation
    for part in get_args(annotation):
        yield from _plain_types(part)


def _default(value: Any, field: Any) -> str:
    if value is None or value is PydanticUndefined:
        return "none"
    if isinstance(value, Table):
        return "its defaults"
    if isinstance(value, bool):
        return str(value).lower()
    quantity = next((entry for entry in field.metadata if isinstance(entry, Quantity)), None)
    quantity = quantity or quantity_of(field.annotation)
    if quantity is not None and isinstance(value, float):
        return f'"{quantity.format(value)}"'
    if isinstance(value, tuple | list | dict):
        parts = get_args(field.annotation)
        unit = quantity_of(parts[0]) if value and parts else None
        return f"[{', '.join(unit.format(one) if unit else f'{one:g}' for one in value)}]"
    return f"{value:.6g}" if isinstance(value, float) else f'"{value}"' if isinstance(value, str) else str(value)


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _scene_page() -> str:
    lines = [
        "# Keys of a scene",
        "",
        GENERATED,
        "",
        f"`{ENTRY}` stands for the number of an entry from 0, or for its name. The kind of a step or of an end stands",
        'in brackets where a key belongs to it. Quantities are texts with any unit of their kind, such as `"6 mm"`;',
        "the unit in brackets is the one of bounds. `none` removes a key that may be absent.",
        "",
        _row("key", "value", "default", "meaning"),
        "|---|---|---|---|",
    ]
    rows = [_row(f"`{key.path}`", key.kind, f"`{key.default}`", key.meaning) for key in scene_keys()]
    return "\n".join([*lines, *rows]) + "\n"


def _tables_page() -> str:
    lines = ["# Columns of tables", "", GENERATED, ""]
    for table, columns in TABLES.items():
        lines += [
            f"## `{table}.csv`",
            "",
            f"A row is {ROWS[table]}.",
            "",
            _row("column", "unit", "meaning"),
            "|---|---|---|",
        ]
        lines += [_row(f"`{name}`", unit_of_column(name), COLUMNS[name]) for name in columns]
        if table == "force":
            lines.append(_row("`NAME_Nmm`", "N mm", "energy of a further term: stored now, or dissipated so far"))
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _fields_page() -> str:
    lines = [
        "# Fields of `results.vtkhdf`",
        "",
        GENERATED,
        "",
        "Each array has the attributes `description`, `unit` and, where it has several components, `components`.",
        "",
        _row("field", "unit", "components", "on", "model", "meaning"),
        "|---|---|---|---|---|---|",
    ]
    rows = [_row(f"`{n}`", f.unit, f.components, f.places, f.models, f.text) for n, f in FIELDS.items()]
    return "\n".join([*lines, *rows]) + "\n"


if __name__ == "__main__":
    write_pages(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/reference"))
