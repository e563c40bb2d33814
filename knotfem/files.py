"""Files that are whole or not there: written beside their place, then renamed."""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, InUse, cannot_read, cannot_write

LARGEST_INPUT = 2**26
"""Of a scene, a curve, a cross-section or a study [bytes]."""
PART_SUFFIX = ".part"
"""Ends the names of files that are not whole yet."""


def unfinished(path: Path) -> Path:
    """Where this process puts together what a path is to hold, beside it."""
    return path.with_name(f".{path.name}.{os.getpid()}{PART_SUFFIX}")


def write_atomically(path: Path, content: str | bytes) -> None:
    """Replace a file as a whole; a reader, a crash or a full disk never sees a part of it.

    A link stays one, the file it points to is replaced; what is no file, such as a terminal, is written to.

    Raises:
        InputError: the disk is full or the folder cannot be written; the old file, if any, is untouched.
    """
    data = content.encode() if isinstance(content, str) else content
    whole = path.resolve()
    temporary = unfinished(whole)
    try:
        if whole.exists() and not whole.is_file() and not whole.is_dir():
            whole.write_bytes(data)
            return
        with temporary.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(whole)
    except OSError as error:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise cannot_write(path, error) from error


def check_regular(path: Path) -> None:
    """Refuse to read what is no file, such as a pipe or a device, or is larger than any input of this program.

    Raises:
        InputError: it is; missing files and folders are left to whoever reads them.
    """
    try:
        found = path.stat()
    except OSError:
        return
    if stat.S_ISDIR(found.st_mode):
        return
    if not stat.S_ISREG(found.st_mode):
        raise InputError("not a regular file", file=path, found="a pipe or a device", expected="a file")
    if found.st_size > LARGEST_INPUT:
        size, most = (f"{bytes_ / 2**20:.0f} MB" for bytes_ in (found.st_size, LARGEST_INPUT))
        raise InputError("too large a file", file=path, found=size, expected=f"at most {most}")


def read_text(path: Path, otherwise: str = "") -> str:
    """Text of an input file in UTF-8, with or without a byte order mark.

    Args:
        path: of the file.
        otherwise: encoding of files that are not UTF-8; "" refuses them.

    Raises:
        InputError: it cannot be read, or is no text.
    """
    check_regular(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise cannot_read(path, error) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode(otherwise, errors="replace") if otherwise else "\0"
    if "\0" in text:
        expected = f"UTF-8 or {otherwise.capitalize()} text" if otherwise else "UTF-8 text"
        raise InputError("not a text file", file=path, expected=expected)
    return text


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write indented JSON as a whole; NaN and infinity become null.

    Raises:
        InputError: as `write_atomically`.
    """
    write_atomically(path, json.dumps(_plain(data), indent=2, allow_nan=False) + "\n")


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object.

    Raises:
        InputError: missing, unreadable or damaged.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise cannot_read(path, error) from None
    except ValueError as error:
        raise InputError(f"not a JSON file: {error}", file=path) from None
    if not isinstance(data, dict):
        raise InputError("not a JSON object", file=path)
    return data


def json_line(data: Mapping[str, Any]) -> str:
    """One line of JSON, with its newline; NaN and infinity become null."""
    return json.dumps(_plain(data), allow_nan=False) + "\n"


def append(path: Path, text: str) -> None:
    """Append to a file in one write that reaches the disk, or leave the file as it was.

    Raises:
        InputError: the disk is full or the file cannot be written.
    """
    data = text.encode()
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            length = os.fstat(descriptor).st_size
            try:
                if os.write(descriptor, data) < len(data):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(descriptor)
            except OSError:
                os.ftruncate(descriptor, length)
                raise
        finally:
            os.close(descriptor)
    except OSError as error:
        raise cannot_write(path, error) from error


@contextmanager
def held(lock: Path, busy: InUse) -> Iterator[None]:
    """Hold a lock file for this process; ends with the process, however that ends.

    A process that is killed leaves the file, but not the lock.

    Args:
        lock: the file.
        busy: raised where another process holds it.

    Raises:
        InUse: `busy`.
        InputError: the file cannot be written.
    """
    from filelock import FileLock, Timeout

    file_lock = FileLock(lock, timeout=0)
    try:
        file_lock.acquire()
    except Timeout:
        raise busy from None
    except OSError as error:
        raise cannot_write(lock, error) from error
    try:
        yield
    finally:
        with suppress(OSError):  # Windows removes it on release
            lock.unlink(missing_ok=True)
        file_lock.release()


def whole_lines(path: Path) -> list[str]:
    """Lines of a text file without a last one that a crash has cut short."""
    text = path.read_text(encoding="utf-8")
    return text[: text.rfind("\n") + 1].splitlines()


def _plain(value: Any) -> Any:
    """Plain JSON values from NumPy scalars, arrays, paths and tuples."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    return str(value) if isinstance(value, Path) else value
