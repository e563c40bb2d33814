"""Checkpoints: the whole state of a run in one HDF5 file, read back to the last bit."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError, cannot_write
from knotfem.files import write_atomically

_TREE = "tree"
_ARRAY, _TUPLE = "$array", "$tuple"


@dataclass(frozen=True)
class Checkpoint:
    """A state that a run goes on from.

    Attributes:
        state: nested dictionaries, lists and tuples of arrays, NumPy scalars and plain values.
        metadata: plain values that describe it, such as the step and the rows of the tables.
        path: the file.
        damaged: newer files that cannot be read, newest first.
    """

    state: dict[str, Any]
    metadata: dict[str, Any]
    path: Path
    damaged: tuple[Path, ...] = ()


@dataclass(frozen=True, eq=False)
class RunCheckpoint:
    """What a checkpoint of a run holds.

    Attributes:
        simulation: see `knotfem.run.simulation.Simulation.checkpoint`.
        summary: see `knotfem.run.summary.Summary.state`.
        rows: of each table, of the log and of the time series, so far.
    """

    simulation: dict[str, Any]
    summary: dict[str, Any]
    rows: dict[str, int]

    def __repr__(self) -> str:
        return f"<checkpoint of a run with {sum(self.rows.values())} rows of tables>"

    @classmethod
    def of(cls, checkpoint: Checkpoint) -> RunCheckpoint:
        """From a file.

        Raises:
            InputError: it is of an older version.
        """
        state = checkpoint.state
        try:
            return cls(state["simulation"], state["summary"], checkpoint.metadata["rows"])
        except KeyError:
            raise InputError(
                "the checkpoint is of an older version", file=checkpoint.path, expected="a new run"
            ) from None

    @property
    def state(self) -> dict[str, Any]:
        """For a file, without the rows."""
        return {"simulation": self.simulation, "summary": self.summary}


class CheckpointStore:
    """The checkpoints of a run, of which the newest and those with a name are kept.

    Attributes:
        folder: where they lie; made when the first is written.
        keep: how many without a name stay.
    """

    def __init__(self, folder: Path, keep: int = 2) -> None:
        self.folder, self.keep = folder, keep

    def paths(self) -> list[Path]:
        """Files, oldest first."""
        return sorted(self.folder.glob("checkpoint-*.h5"))

    def save(self, state: Mapping[str, Any], metadata: Mapping[str, Any], name: str = "") -> Path:
        """Write the next checkpoint, then drop old ones without a name.

        Args:
            state: nested dictionaries (string keys), lists and tuples of arrays, NumPy scalars, numbers, text, None.
            metadata: values that JSON holds.
            name: of a state that stays, such as "tied"; replaces an older one of this name.

        Raises:
            TypeError: a value that cannot be kept; a programming error.
            InputError: the disk is full or the folder cannot be written; older checkpoints are untouched.
        """
        return self._add(_encode(state, metadata), name)

    def adopt(self, path: Path, **metadata: Any) -> Path:
        """Copy a checkpoint of another run as the newest of this one, name included.

        Args:
            path: the file.
            **metadata: that takes the place of the copied one's.

        Raises:
            InputError: it cannot be read or written.
        """
        checkpoint = read_checkpoint(path)
        return self.save(checkpoint.state, {**checkpoint.metadata, **metadata}, _name(path))

    def latest(self) -> Checkpoint | None:
        """The newest checkpoint that can be read, or none where there is no file.

        Raises:
            InputError: all are damaged; says what is wrong with the newest.
        """
        damaged: list[tuple[Path, InputError]] = []
        for path in reversed(self.paths()):
            try:
                checkpoint = read_checkpoint(path)
            except InputError as error:
                damaged.append((path, error))
            else:
                return replace(checkpoint, damaged=tuple(path for path, _ in damaged))
        if damaged:
            raise damaged[0][1]
        return None

    def metadata(self) -> dict[str, Any]:
        """Metadata of the newest checkpoint that can be read; empty without one."""
        for path in reversed(self.paths()):
            with suppress(InputError):
                return read_metadata(path)
        return {}

    def named(self, name: str) -> Path | None:
        """File of the checkpoint with this name, or none."""
        return next((path for path in reversed(self.paths()) if _name(path) == name), None)

    def _add(self, content: bytes, name: str) -> Path:
        try:
            self.folder.mkdir(exist_ok=True)
        except OSError as error:
            raise cannot_write(self.folder, error) from error
        existing = self.paths()
        number = _number(existing[-1]) + 1 if existing else 1
        path = self.folder / f"checkpoint-{number:06d}{f'-{name}' if name else ''}.h5"
        write_atomically(path, content)
        same = [old for old in [*existing, path] if _name(old) == name]
        for old in same[: -1 if name else -self.keep]:
            old.unlink(missing_ok=True)
        return path


def _number(path: Path) -> int:
    return int(path.stem.split("-")[1])


def _name(path: Path) -> str:
    return "-".join(path.stem.split("-")[2:])


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint.

    Raises:
        InputError: missing or damaged.
    """
    with _opened(path) as file:
        tree = json.loads(bytes(_dataset(file, _TREE)))
        return Checkpoint(_decode(tree["state"], _dataset_group(file)), tree["metadata"], path)


def read_metadata(path: Path) -> dict[str, Any]:
    """Read the metadata of a checkpoint alone.

    Raises:
        InputError: missing or damaged.
    """
    with _opened(path) as file:
        return dict(json.loads(bytes(_dataset(file, _TREE)))["metadata"])


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The file of a checkpoint, open for reading; what is wrong inside is said in one message."""
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        raise InputError(f"no readable checkpoint ({error})", file=path) from None


def _encode(state: Mapping[str, Any], metadata: Mapping[str, Any]) -> bytes:
    """The HDF5 file: numbered arrays, and one JSON tree that refers to them."""
    import h5py

    arrays: list[np.ndarray] = []
    tree = json.dumps({"state": _to_tree(state, arrays), "metadata": metadata}).encode()
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.create_dataset(_TREE, data=np.frombuffer(tree, dtype=np.uint8))
        group = file.create_group("arrays")
        for index, array in enumerate(arrays):
            group.create_dataset(str(index), data=array)
    return buffer.getvalue()


def _to_tree(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) and not key.startswith("$") for key in value):
            raise TypeError("a checkpoint takes dictionaries with text keys")
        return {key: _to_tree(item, arrays) for key, item in value.items()}
    if isinstance(value, tuple | list):
        items = [_to_tree(item, arrays) for item in value]
        return {_TUPLE: items} if isinstance(value, tuple) else items
    if isinstance(value, np.ndarray | np.generic):
        return _array_to_tree(value, arrays)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a checkpoint takes no {type(value).__name__}")


def _array_to_tree(value: np.ndarray | np.generic, arrays: list[np.ndarray]) -> dict[str, Any]:
    array = np.asarray(value)
    if array.dtype.kind not in "biufc":
        raise TypeError(f"a checkpoint takes no arrays of {array.dtype}")
    arrays.append(np.ascontiguousarray(array) if array.ndim else array)
    order = "F" if array.flags.f_contiguous and not array.flags.c_contiguous else "C"
    return {_ARRAY: len(arrays) - 1, "order": order, "scalar": isinstance(value, np.generic)}


def _decode(tree: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if isinstance(tree, list):
        return [_decode(item, arrays) for item in tree]
    if not isinstance(tree, dict):
        return tree
    if _TUPLE in tree:
        return tuple(_decode(item, arrays) for item in tree[_TUPLE])
    if _ARRAY in tree:
        array = arrays[str(tree[_ARRAY])]
        return array[()] if tree["scalar"] else np.array(array, order=tree["order"])
    return {key: _decode(item, arrays) for key, item in tree.items()}


def _dataset(group: Any, name: str) -> np.ndarray:
    return np.asarray(group[name][()])


def _dataset_group(file: Any) -> dict[str, np.ndarray]:
    return {name: _dataset(file["arrays"], name) for name in file["arrays"]}
