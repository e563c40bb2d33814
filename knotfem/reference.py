"""Reference of scene keys, columns, fields and figures, made from the code: units, defaults, bounds, meaning.

`python -m knotfem.reference FOLDER` writes its pages.
"""

from __future__ import annotations

import difflib
import inspect
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic_core import PydanticUndefined

from knotfem.errors import InputError
from knotfem.files import write_atomically
from knotfem.run import column_meanings as of_runs
from knotfem.run.column_meanings import unit_of_column
from knotfem.run.field_meanings import FIELDS
from knotfem.run.summary_meanings import FILES, NAME, SUMMARY
from knotfem.scene.model import Scene
from knotfem.scene.quantity import Quantity
from knotfem.scene.rope import quantity_of
from knotfem.scene.table import Table
from knotfem.study import column_meanings as of_studies

GENERATED = "Made from the code by `python -m knotfem.reference docs/reference`; `knotfem help KEY` says the same."
TABLES = {
    **{table: {name: of_runs.COLUMNS[name] for name in columns} for table, columns in of_runs.TABLES.items()},
    **of_studies.TABLES,
}
"""Columns and their meanings, by table."""
ROWS = of_runs.ROWS | of_studies.ROWS
SIGNS = {Gt: ">", Ge: ">=", Lt: "<", Le: "<="}
ENTRY = "N"
"""Stands for the number of an entry of a list."""
LIST = "list of tables"
"""Kind of a key with entries that have keys of their own."""


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
        return tuple(part for part in self.parts if part != ENTRY)

    @property
    def parts(self) -> tuple[str, ...]:
        """Parts of the path without kinds."""
        return tuple(re.sub(r"\[[^]]*\]", "", self.path).split("."))

    def is_called(self, name: Sequence[str]) -> bool:
        """Whether parts of a dotted name are the end of its path, entries of lists being numbers, names or left out."""
        entry = self.kind == LIST and _ends_with((*self.parts, ENTRY), name)
        return entry or _ends_with(self.parts, name)


@cache
def scene_keys() -> tuple[Key, ...]:
    """All keys of a scene, in its order."""
    return tuple(_keys(Scene, ""))


def look_up(name: str) -> str:
    """What a key of a scene, a column, a field, a key of summary.json or a file is.

    Args:
        name: such as "contact.friction", "rods.0.length", "steps.1.ends.rod.start.direction", "unrest_N", "twist",
            "holding", "force.csv".

    Raises:
        InputError: nothing has this name.
    """
    found = [f"key of a scene: {key}{_inside(key)}" for key in _called(name)]
    found += _of_column(name)
    if name in FIELDS:
        field = FIELDS[name]
        order = f", components {field.components}" if field.components else ""
        where = f"{field.places}; model {field.models}"
        found.append(f"field of results.vtkhdf: {name}\n  {field.text} [{field.unit}]{order}\n  on {where}")
    found += [_of_summary(key) for key in SUMMARY if _ends_with(tuple(key.split(".")), name.split("."), NAME)]
    table = name.removesuffix(".csv")
    if table in TABLES:
        found.append(f"table {table}.csv\n  a row is {ROWS[table]}\n  columns: {', '.join(TABLES[table])}")
    found += [f"file {file}\n  {text}" for file, text in FILES.items() if name in (file, file.rpartition(".")[0])]
    if not found:
        raise InputError("nothing has this name", key="help", found=f'"{name}"', expected=_closest(name))
    return "\n\n".join(found)


def names() -> Iterator[str]:
    """Names of columns, and of keys of summary.json as they end and as they are written whole."""
    for table in TABLES.values():
        yield from table
    yield from (key.rpartition(".")[2] for key in SUMMARY)
    yield from SUMMARY


def _of_column(name: str) -> list[str]:
    """What columns of this name are: an entry for each meaning."""
    files: dict[str, list[str]] = {}
    for table, columns in TABLES.items():
        if name in columns:
            files.setdefault(columns[name], []).append(f"{table}.csv")
    unit = unit_of_column(name)
    return [f"column of {', '.join(of)}: {name}\n  {text}{f' [{unit}]' if unit else ''}" for text, of in files.items()]


def _closest(name: str) -> str:
    """What may have been meant by a name that nothing has: of a dotted one the whole key."""
    paths = [key.plain for key in scene_keys()] + [tuple(key.split(".")) for key in SUMMARY]
    columns = [column for table in TABLES.values() for column in table]
    *above, last = name.split(".")
    found = difflib.get_close_matches(last, dict.fromkeys([*(p[-1] for p in paths), *columns, *FIELDS, *TABLES]), n=1)
    if not found:
        return "a key of a scene or of summary.json, a column or a field"
    whole = [".".join(path) for path in paths if path[-1] == found[0]] if above else []
    return f'"{(difflib.get_close_matches(name, whole, n=1, cutoff=0.0) or found)[0]}"'


def _called(name: str) -> list[Key]:
    """Keys of a scene that a name may mean; a number at its end may be that of a value in a list."""
    parts = ["centerline" if part == "centreline" else part for part in _without_kinds(name).split(".") if part]
    while parts:
        found = [key for key in scene_keys() if key.is_called(parts)]
        if found or not parts[-1].isdecimal():
            return found
        parts.pop()
    return []


def _without_kinds(path: str) -> str:
    return re.sub(r"\[[^]]*\]", "", path)


def _ends_with(pattern: Sequence[str], name: Sequence[str], entry: str = ENTRY) -> bool:
    """Whether a name is the end of a path in which `entry` stands for any name or number, or is left out.

    A name begins with a part of the path itself, or with a number.
    """
    if not name:
        return True
    if not pattern:
        return False
    *before, last = pattern
    if last != entry:
        return last == name[-1] and _ends_with(before, name[:-1], entry)
    as_entry = len(name) > 1 or name[-1].isdecimal() or name[-1] == entry
    return (as_entry and _ends_with(before, name[:-1], entry)) or _ends_with(before, name, entry)


def _inside(table: Key) -> str:
    """The keys of a table, below its own entry."""
    if table.kind not in (LIST, "table"):
        return ""
    place = f"{table.path}.{ENTRY}" if table.kind == LIST else table.path
    below = [key.path for key in scene_keys() if re.match(rf"{re.escape(place)}(\[[^]]*\])?\.[^.]+$", key.path)]
    return f"\n  keys     {', '.join(below)}" if below else ""


def _of_summary(key: str) -> str:
    """Entry of a key of summary.json, with those below it."""
    below = [name for name in SUMMARY if name.startswith(f"{key}.")]
    more = f"\n  keys     {', '.join(name.removeprefix(f'{key}.') for name in below)}" if below else ""
    unit = unit_of_column(key.rpartition(".")[2])
    return f"key of summary.json: {key}\n  {SUMMARY[key]}{f' [{unit}]' if unit else ''}{more}"


def pages() -> dict[str, str]:
    """Pages of the reference by file name."""
    return {
        "scene.md": _scene_page(),
        "tables.md": _tables_page(),
        "fields.md": _fields_page(),
        "summary.md": _summary_page(),
    }


def write_pages(folder: Path) -> None:
    """Write the pages into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        write_atomically(folder / name, text)


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
        return LIST if _is_list(annotation) else "table"
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
        lines += [_row(f"`{name}`", unit_of_column(name), text) for name, text in columns.items()]
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


def _summary_page() -> str:
    lines = [
        "# Keys of `summary.json`, files of a run",
        "",
        GENERATED,
        "",
        f"`{NAME}` stands for the name of a phase, an effect, a rod or a measure.",
        "",
        _row("key", "unit", "meaning"),
        "|---|---|---|",
    ]
    lines += [_row(f"`{key}`", unit_of_column(key.rpartition(".")[2]), text) for key, text in SUMMARY.items()]
    lines += ["", "## Files", "", _row("file", "what"), "|---|---|"]
    lines += [_row(f"`{file}`", text) for file, text in FILES.items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    write_pages(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/reference"))
