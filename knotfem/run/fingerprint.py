"""What a state was computed from: keys of the scene that decide it, and hashes of the files that the scene names."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, cannot_read
from knotfem.scene.model import Scene

SETTINGS = ("solver", "output")
"""Tables of a scene that may change while a run goes on."""
_RECORDS = ("name", "description", "accuracy", "rope")
"""Keys of a scene that change nothing."""


@dataclass(frozen=True)
class Difference:
    """The first key in which two scenes differ.

    Attributes:
        key: dotted.
        before: its value in the first, as text.
        now: in the second.
    """

    key: str
    before: str
    now: str


def fingerprint(scene: Scene) -> dict[str, Any]:
    """What decides a run's states, as plain values for a checkpoint."""
    keys = scene.model_dump(mode="json", exclude={*SETTINGS, *_RECORDS})
    return {"scene": keys, "files": dict(_hashes(scene))}


def scene_difference(before: Scene, now: Scene) -> Difference | None:
    """Where two scenes differ in what decides a run's states; None where they do not."""
    return first_difference(fingerprint(before)["scene"], fingerprint(now)["scene"])


def check_fingerprint(recorded: Mapping[str, Any] | None, scene: Scene, file: Path) -> None:
    """Refuse a scene that is not the one which a state was computed from.

    Args:
        recorded: `fingerprint` of that scene; None of a state without one.
        scene: as it is now.
        file: that it was read from, for the message.

    Raises:
        InputError: the first key that differs, or a file whose content does.
    """
    if recorded is None:
        return
    now, problem = fingerprint(scene), "changed since the run was computed"
    found = first_difference(recorded["scene"], now["scene"])
    if found is not None:
        expected = f"{found.before}; for another value start another run with -o"
        raise InputError(problem, file=file, key=found.key, found=found.now, expected=expected)
    for key, digest in recorded["files"].items():
        if now["files"].get(key) != digest:
            expected = "the file as it was, or another run with -o"
            raise InputError(f"the file {problem}", file=file, key=key, found=_named(key, scene), expected=expected)


def first_difference(before: object, now: object, key: str = "") -> Difference | None:
    """The first difference of two trees of plain values; keys that only the second has are of a newer version.

    Args:
        before: dictionaries, lists, and values.
        now: likewise.
        key: of both, within a larger tree.
    """
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        pairs = [(name, value, now.get(name)) for name, value in before.items()]
    elif isinstance(before, list | tuple) and isinstance(now, list | tuple) and len(before) == len(now):
        pairs = [(str(i), *both) for i, both in enumerate(zip(before, now, strict=True))]
    else:
        return None if before == now else Difference(key, _said(before), _said(now))
    found = (first_difference(old, new, f"{key}.{name}".removeprefix(".")) for name, old, new in pairs)
    return next((difference for difference in found if difference is not None), None)


def _said(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return f"{len(value)} entries"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _hashes(scene: Scene) -> Iterator[tuple[str, str]]:
    for i, rod in enumerate(scene.rods):
        yield f"rods.{i}.centerline", _hash(rod.curve_file)
        if rod.mesh.section is not None:
            yield f"rods.{i}.mesh.section", _hash(Path(rod.mesh.section))


def _hash(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise cannot_read(path, error) from None


def _named(key: str, scene: Scene) -> str:
    rod = scene.rods[int(key.split(".")[1])]
    return str(rod.centerline if key.endswith("centerline") else rod.mesh.section)
