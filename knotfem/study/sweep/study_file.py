"""The file of a study: a base scene, axes, what is set for all points, what is collected."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationError, model_validator

from knotfem.errors import OVERRIDES, InputError, SeveralErrors
from knotfem.run.columns import FORCE_COLUMNS, FORCE_EXTRA, TENSION_COLUMNS, TENSION_EXTRA
from knotfem.scene.load import Overrides, changes_of, read_toml
from knotfem.scene.quantity import Length
from knotfem.scene.rope import Rope, read_rope
from knotfem.scene.table import Flag, Integer, Number, Table, input_errors, known_name, refusal

WAYS = ("values", "linspace", "geomspace", "random")
STUDY_FILE = "study.toml"
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
"""A number and its unit, if any."""
RESERVED = ("point", "state", "verdict", "failure_mode", "reason")
"""Columns of every study's table beside the keys."""
_TEXT = ("step", "rod")
_COLUMNS = {
    "force": [name for name in (*FORCE_COLUMNS, *FORCE_EXTRA) if name not in _TEXT],
    "tension": [name for name in (*TENSION_COLUMNS, *TENSION_EXTRA) if name not in _TEXT],
}

Bound = Number | Annotated[str, Field(pattern=NUMBER.pattern)]
"""A number, or one with a unit."""


class Random(Table):
    """Values drawn at random; the same ones for the same seed and key.

    Attributes:
        low, high: between which they lie.
        count: how many.
        seed: of the generator.
        logarithmic: whether the logarithms are drawn evenly.
    """

    low: Bound
    high: Bound
    count: Annotated[Integer, Field(ge=1)]
    seed: Annotated[Integer, Field(ge=0)]
    logarithmic: Flag = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_ends(self.low, self.high, positive=self.logarithmic, at="high")
        return self


def _without_none(data: Any) -> Any:
    return ["none" if value is None else value for value in data] if isinstance(data, list | tuple) else data


class Values(Table):
    """Values of one key, in exactly one of four ways.

    Attributes:
        values: a list.
        linspace: first, last, how many, evenly spaced.
        geomspace: first, last, how many, in a constant ratio.
        random: drawn.
    """

    values: Annotated[tuple[Any, ...], Field(min_length=1), BeforeValidator(_without_none)] | None = None
    linspace: tuple[Bound, Bound, Annotated[Integer, Field(ge=1)]] | None = None
    geomspace: tuple[Bound, Bound, Annotated[Integer, Field(ge=1)]] | None = None
    random: Random | None = None

    @property
    def ways(self) -> list[str]:
        """In which the values are given."""
        return [way for way in WAYS if getattr(self, way) is not None]

    @property
    def count(self) -> int:
        """How many values there are."""
        if self.values is not None:
            return len(self.values)
        spaced = self.linspace or self.geomspace
        return spaced[2] if spaced is not None else self.random.count if self.random is not None else 0

    @model_validator(mode="after")
    def _check_way(self) -> Self:
        return self._one_way()

    def _one_way(self) -> Self:
        if len(self.ways) != 1:
            found = ", ".join(self.ways) or "none"
            raise refusal("values in no or several ways", found=found, expected=f"one of {', '.join(WAYS)}")
        if self.linspace is not None:
            _check_ends(*self.linspace[:2], at="linspace")
        if self.geomspace is not None:
            _check_ends(*self.geomspace[:2], positive=True, at="geomspace")
        return self


def _list_of_values(data: Any) -> Any:
    return {"values": data} if isinstance(data, list | tuple) else data


class Axis(Values):
    """One direction of the grid of points: values of a key, or keys that move together.

    Attributes:
        key: of the scene, or "scene"; with one of the ways of `Values`.
        zip: values by key, all of the same number.
    """

    key: str | None = None
    zip: dict[str, Annotated[Values, BeforeValidator(_list_of_values)]] | None = None

    @model_validator(mode="before")
    @classmethod
    def _flatten(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and isinstance(data.get("zip"), Mapping):
            return {**data, "zip": flat(data["zip"], lambda value: set(value) <= set(WAYS))}
        return data

    @model_validator(mode="after")
    def _check_way(self) -> Self:
        if self.zip is None:
            if self.key is None:
                raise refusal("missing key", at="key", expected='such as "contact.friction", or zip')
            return self._one_way()
        if self.key is not None or self.ways:
            raise refusal("values beside zip", at="zip", found=self.key, expected="zip alone, or a key with its values")
        counts = {key: values.count for key, values in self.zip.items()}
        if len(set(counts.values())) != 1:
            found = ", ".join(f"{key}: {count}" for key, count in counts.items())
            raise refusal("unequal numbers of values", at="zip", found=found, expected="as many of each key")
        return self

    @property
    def by_key(self) -> dict[str, Values]:
        """Values of the keys that move together."""
        return self.zip if self.zip is not None else {str(self.key): self}


class Collected(Table):
    """A figure of a table of the run.

    Attributes:
        table: "force" or "tension".
        column: of it.
        at: displacement of the reported end [mm], in a pull; the last row by default.
        s_over_L: of "tension": place along the rod, or none for all of it.
        of: of "tension" without a place: what is taken of the values along the rod.
        rod: of "tension": its name; the first by default.
    """

    table: Literal["force", "tension"]
    column: str
    at: Length | None = None
    s_over_L: Annotated[Number, Field(ge=0.0, le=1.0)] | None = None  # noqa: N815
    of: Literal["max", "min", "mean"] = "max"
    rod: str | None = None

    @model_validator(mode="after")
    def _check_column(self) -> Self:
        if not (self.table == "force" and self.column.endswith("_Nmm")):
            known_name(self.column, _COLUMNS[self.table], f"column of {self.table}.csv", at="column")
        return self


Wanted = Annotated[
    Annotated[str, Tag("key")] | Annotated[Collected, Tag("figure")],
    Discriminator(lambda value: "key" if isinstance(value, str) else "figure"),
]
"""A dotted key of summary.json, or a figure of a table."""


class Study(Table):
    """What the user asks for.

    Attributes:
        name: of the study.
        folder: where relative paths start; that of the file.
        scene: a shipped name or a file; may be an axis instead.
        rope: another rope, for which scenes are scaled before keys are set; see `Scene.with_rope`.
        axes: whose combinations are the points.
        set: values by key, for all points.
        collect: columns of the table, by name: a dotted key of summary.json, or a figure of a table.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$")] = "study"
    folder: str = ""
    scene: str | None = None
    rope: Rope | None = None
    axes: tuple[Axis, ...] = ()
    set: dict[str, Any] = Field(default_factory=dict)
    collect: dict[str, Wanted] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _flatten(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and isinstance(data.get("set"), Mapping):
            return {**data, "set": _said(flat(data["set"]))}
        return data

    @model_validator(mode="after")
    def _check_names(self) -> Self:
        for place, key in enumerate(self.keys):
            if key in self.keys[:place] or key in self.set:
                raise refusal("used twice", at="axes", found=f'"{key}"', expected="each key in one place")
        if self.scene is None and "scene" not in self.keys:
            raise refusal("missing key", at="scene", expected="a shipped scene or a file, or an axis of this key")
        if "scene" in self.set:
            raise refusal("not among what is set", at="set.scene", expected="scene at the top, or an axis of this key")
        for name in self.collect:
            if name in (*RESERVED, *self.keys):
                raise refusal("a column has this name", at=f"collect.{name}", expected="another name")
        return self

    @property
    def keys(self) -> list[str]:
        """Keys of all axes, in order."""
        return [key for axis in self.axes for key in axis.by_key]

    @property
    def base(self) -> Path:
        """Where relative paths start."""
        return Path(self.folder)


def flat(tables: Mapping[str, Any], leaf: Any = lambda value: False) -> dict[str, Any]:
    """Values by dotted key; TOML reads a dotted key that is not quoted as tables in tables.

    Args:
        tables: nested.
        leaf: whether a table is a value itself.
    """
    found: dict[str, Any] = {}
    for key, value in tables.items():
        if isinstance(value, Mapping) and value and not leaf(value):
            found |= {f"{key}.{below}": item for below, item in flat(value, leaf).items()}
        else:
            found[key] = value
    return found


def number_and_unit(bound: float | str) -> tuple[float, str]:
    """A bound as a number and its unit, "" for none."""
    if not isinstance(bound, str):
        return float(bound), ""
    match = NUMBER.fullmatch(bound)
    assert match is not None, "validated"
    return float(match.group(1)), match.group(2)


def _check_ends(low: float | str, high: float | str, *, at: str, positive: bool = False) -> None:
    """Refuse bounds of different units, and logarithms of what has none."""
    (first, unit), (last, other) = number_and_unit(low), number_and_unit(high)
    if unit != other:
        raise refusal("two units", at=at, found=f"{low}, {high}", expected="the same unit")
    if positive and not first * last > 0.0:
        raise refusal("no constant ratio", at=at, found=f"{low}, {high}", expected="two numbers of the same sign")


def read_study(
    source: str | Path | Mapping[str, Any], overrides: Overrides = (), rope: Mapping[str, Any] | None = None
) -> Study:
    """Read and validate a study.

    Args:
        source: a TOML file, a study's folder, or the tables themselves.
        overrides: of keys of the scenes, for all points; they are added to what is set.
        rope: instead of the one that the study has; None leaves that.

    Raises:
        InputError: no such file, or all that is wrong with it at once.
    """
    if isinstance(source, Mapping):
        tables, file, name, folder = dict(source), None, "study", Path.cwd()
    else:
        file = Path(source) / STUDY_FILE if Path(source).is_dir() else Path(source)
        tables = read_toml(file)
        name, folder = re.sub(r"[^A-Za-z0-9_.-]+", "-", file.stem), file.resolve().parent
    chosen = {"name": name, **tables, "folder": str(tables.get("folder") or folder)}
    try:
        study = Study.model_validate(chosen)
    except ValidationError as error:
        raise SeveralErrors(input_errors(error, chosen, file=file)) from None
    changes = changes_of(overrides)
    for key in changes:
        if key in study.keys or key == "scene":
            raise InputError("an axis has this key", file=OVERRIDES, key=key, expected="another key")
    wanted = read_rope(rope) if rope else study.rope
    return study.model_copy(update={"set": {**study.set, **_said(changes)}, "rope": wanted})


def study_text(study: Study) -> str:
    """The study as TOML; reading it again gives the same one."""
    import tomlkit

    tables = study.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    for name, wanted in tables.get("collect", {}).items():
        if isinstance(wanted, dict):  # in one line, for TOML puts tables last and the columns have an order
            tables["collect"][name] = tomlkit.inline_table()
            tables["collect"][name].update(wanted)
    return tomlkit.dumps(tables)


def _said(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values in whose stead None, which TOML does not have, is the text none: it removes a key."""
    return {key: "none" if value is None else value for key, value in values.items()}
