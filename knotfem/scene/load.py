"""Read a scene: a TOML file or a shipped name, with overrides from the command line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from knotfem import shipped
from knotfem.errors import OVERRIDES, InputError, cannot_read
from knotfem.files import check_regular
from knotfem.scene.effects import Cylinder
from knotfem.scene.model import Scene
from knotfem.scene.rods import Rod, is_curve_file
from knotfem.scene.table import input_errors, one_error

_ALTERNATIVES = {"section": "section_elements", "section_elements": "section"}
"""Keys of a rod's mesh of which only one may be given."""
_NAMES = {"rods": Rod.model_fields["name"].default, "obstacles": Cylinder.model_fields["name"].default}
"""Names of entries of lists that are not named; steps go by their kind."""
_SPELLINGS = {"centreline": "centerline"}
"""Keys of a rod that may be spelt in two ways: as scenes may have them, and as a rod names them."""

Overrides = Mapping[str, Any] | Sequence[str] | str
"""Changes of scene keys: {"contact.friction": 0.37}, or texts such as "contact.friction=0.37", or one of them."""


def load_scene(
    source: str | Path | Scene,
    overrides: Overrides = (),
    folder: Path = Path(),
    *,
    rope: Mapping[str, Any] | None = None,
) -> Scene:
    """Read and validate a scene.

    Args:
        source: a shipped name, a TOML file, or a scene to be changed.
        overrides: values by `key.path`, entries of lists by index or name, such as {"rods.0.length": "500 mm",
            "steps.pull.speed": "2 mm/s"}, None removing a key; or texts `key.path=value` or a single one, the value
            being TOML, or text where it is not TOML, and the bare word none removing a key.
        folder: where relative paths in overrides start; the working directory by default.
        rope: another rope, such as {"diameter": "10 mm", "youngs_modulus": "5 MPa", "friction": 0.25}, for which the
            scene is scaled before it is changed; see `Scene.with_rope`.

    Raises:
        InputError: no such scene, broken TOML, or keys that are wrong, all of them.
    """
    if rope:
        source = load_scene(source).with_rope(**rope)
    if isinstance(source, Scene) and not overrides:
        return source
    tables, path = _tables_of(source)
    _make_uniform(tables, path.parent, path)
    original, changes = deepcopy(tables), changes_of(overrides)
    places = _change(tables, changes, folder)
    try:
        return Scene.model_validate(tables)
    except ValidationError as error:
        found = [_locate(one, path, places) for one in input_errors(error, tables)]
    raise one_error([_blame(one, path, original, changes, folder) for one in found])


def _change(tables: dict[str, Any], changes: Mapping[str, Any], folder: Path) -> dict[str, list[str]]:
    """Set and remove keys; returns the parts of each, see `_override`."""
    for key, value in changes.items():
        _make_room(tables, key, value)
    places = {key: _override(tables, key, value) for key, value in changes.items()}
    _make_uniform(tables, folder, OVERRIDES)
    return places


def _blame(
    error: InputError, path: Path, original: Mapping[str, Any], changes: Mapping[str, Any], folder: Path
) -> InputError:
    """An error at a key of the file, at the overrides without which it would not be there.

    Args:
        error: as it was located.
        path: of the file.
        original: tables of the file.
        changes: all overrides.
        folder: where their relative paths start.
    """
    if error.file != path or not changes:
        return error

    def remains(some: Mapping[str, Any]) -> bool:
        tables = deepcopy(dict(original))
        try:
            _change(tables, some, folder)
            Scene.model_validate(tables)
        except ValidationError as found:
            return any((one.key, one.problem) == (error.key, error.problem) for one in input_errors(found, tables))
        except InputError:  # an override that needs another one
            return True
        return False

    if remains({}):
        return error
    guilty = [key for key in changes if not remains({other: value for other, value in changes.items() if other != key})]
    problem = f"makes {error.key} wrong: {error.problem}"
    culprits = " and ".join(guilty or changes)
    return InputError(problem, file=OVERRIDES, key=culprits, found=error.found, expected=error.expected)


def _tables_of(source: str | Path | Scene) -> tuple[dict[str, Any], Path]:
    """Tables of a scene, and the file that they are from."""
    if isinstance(source, Scene):
        return source.model_dump(mode="json", exclude_none=True), Path(source.name)
    name = str(source)
    path = shipped.scene_path(name) if name in shipped.scene_names() else Path(name)
    if path.suffix != ".toml" and not path.exists():
        path = shipped.scene_path(name)
    tables = read_toml(path)
    tables.setdefault("name", re.sub(r"[^A-Za-z0-9_.-]+", "-", path.stem))
    return tables, path


def changes_of(overrides: Overrides) -> dict[str, Any]:
    """Values by key; None removes one.

    Raises:
        InputError: a text that is no override.
    """
    if isinstance(overrides, Mapping):
        return {_spelt(key): deepcopy(value) for key, value in overrides.items()}
    changes = {}
    for override in _texts(overrides):
        key, value = _split(override)
        key = _spelt(key)
        changes.pop(key, None)
        changes[key] = None if value.strip() == "none" else _value(value)
    return changes


def _texts(overrides: Sequence[str] | str) -> Sequence[str]:
    """Texts of overrides; one may come alone."""
    return [overrides] if isinstance(overrides, str) else overrides


def _spelt(key: str) -> str:
    """A key as rods name it."""
    above, dot, last = key.rpartition(".")
    return above + dot + _SPELLINGS.get(last, last)


def describe(name: str, overrides: Sequence[str] | str = ()) -> str | None:
    """One line about a shipped scene; none if it refuses the overrides.

    Args:
        name: of the scene.
        overrides: as for `load_scene`; without any, the scene is not validated.

    Raises:
        InputError: something that is no override at all.
    """
    for override in _texts(overrides):
        _split(override)
    if not overrides:
        return str(read_toml(shipped.scene_path(name)).get("description", ""))
    try:
        return load_scene(name, overrides).description
    except InputError:
        return None


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        InputError: it cannot be read or is no TOML.
    """
    check_regular(path)
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError("no such file", file=path) from None
    except IsADirectoryError:
        raise InputError("this is a directory", file=path, expected="a scene file") from None
    except OSError as error:
        raise cannot_read(path, error) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"not a TOML file: {error}", file=path) from None


def _make_room(tables: dict[str, Any], key: str, value: object) -> None:
    """Drop the key of the file in whose stead an override stands."""
    above, dot, last = key.rpartition(".")
    if dot and last in _ALTERNATIVES and value is not None:
        _override(tables, f"{above}.{_ALTERNATIVES[last]}", None)


def _override(tables: dict[str, Any], key: str, value: object) -> list[str]:
    """Set or remove a key; returns its parts, indices in place of the names of entries of lists."""
    parts, resolved = key.split("."), list[str]()
    place: Any = tables
    for index, part in enumerate(parts[:-1]):
        step = _step_into(place, part, ".".join(parts[: index + 1]))
        resolved.append(str(step))
        place = place[step] if isinstance(place, list) else place.setdefault(step, {})
    step = _step_into(place, parts[-1], ".".join(parts))
    resolved.append(str(step))
    if value is not None:
        place[step] = value
    elif isinstance(place, list) or step in place:
        del place[step]
    return resolved


def _split(override: str) -> tuple[str, str]:
    key, equals, value = override.partition("=")
    if not equals or not all(key.strip().split(".")):
        expected = 'key.path=value, such as "rods.0.length=500 mm"'
        raise InputError("not an override", file=OVERRIDES, found=f'"{override}"', expected=expected)
    return key.strip(), value


def _step_into(place: object, part: str, key: str) -> Any:
    """The key, or the index of a list's entry by its number or name, under which an override goes on."""
    if isinstance(place, dict):
        return part
    if not isinstance(place, list):
        raise InputError("there is no table here", file=OVERRIDES, key=key, expected="a key of the scene")
    if not part.isdecimal() or int(part) >= len(place):
        named = [_name(entry, key.split(".")[-2]) for entry in place]
        if named.count(part) == 1:
            return named.index(part)
        expected = f"an index from 0 to {len(place) - 1}, or a name" if place else "no index, the list is empty"
        raise InputError("no such entry", file=OVERRIDES, key=key, expected=expected)
    return int(part)


def _name(entry: object, table: str) -> object:
    """Name of an entry of a list, given or by default."""
    return entry.get("name", entry.get("kind", _NAMES.get(table))) if isinstance(entry, dict) else None


def _value(text: str) -> object:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()


def _make_uniform(tables: dict[str, Any], folder: Path, file: str | Path) -> None:
    """Spell keys in one way; make files and folders absolute, so that a scene means the same wherever it is written.

    Args:
        tables: of the scene.
        folder: where relative paths start.
        file: to blame in messages.

    Raises:
        InputError: a key is there in both spellings.
    """
    rods = tables.get("rods")
    for index, rod in enumerate(rods if isinstance(rods, list) else ()):
        if not isinstance(rod, dict):
            continue
        for other, key in _SPELLINGS.items():
            if other in rod and key in rod:
                place = f"rods.{index}.{other}"
                raise InputError("the same key twice", file=file, key=place, expected=f"{other} or {key}")
            if other in rod:
                rod[key] = rod.pop(other)
        curve, mesh = rod.get("centerline"), rod.get("mesh")
        if isinstance(curve, str) and curve and _names_file(curve, folder):
            rod["centerline"] = str((folder / curve).resolve())
        if isinstance(mesh, dict) and isinstance(mesh.get("section"), str):
            mesh["section"] = str((folder / mesh["section"]).resolve())
    tie = tables.get("tie")
    if isinstance(tie, dict) and isinstance(tie.get("source"), str):
        tie["source"] = str((folder / tie["source"]).resolve())


def _names_file(curve: str, folder: Path) -> bool:
    """Whether a centreline is a file; one without a suffix counts where it exists and no shipped one has its name."""
    return is_curve_file(curve) or (curve not in shipped.centreline_names() and (folder / curve).is_file())


def _locate(error: InputError, path: Path, places: Mapping[str, list[str]]) -> InputError:
    """Name the override where it set the key, in its own words, else the file.

    Args:
        error: whose key has the indices of entries.
        path: of the file.
        places: parts of the keys that were set, likewise with indices, by the words of the override.
    """
    file, key, parts = path, error.key, (error.key or "").split(".")
    for override, place in places.items():
        common = min(len(place), len(parts))
        if place[:common] == parts[:common]:
            file, key = OVERRIDES, ".".join([*override.split(".")[:common], *parts[common:]])
    return InputError(error.problem, file=file, key=key, found=error.found, expected=error.expected)
