"""Compiled kernels: loops over plain arrays that Numba turns into machine code.

The machine code stays on disk, under a hash of every source that it can be made from: the kernel's module, what that
imports from its own package at module level, and so on. Numba's own cache looks at the kernel's module alone, and
goes on with old code where a kernel of another module has changed that this one inlines or calls.
"""

from __future__ import annotations

import errno
import hashlib
import inspect
import logging
import os
import pickle
import platform
import shutil
import stat
import sys
import tempfile
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast, overload

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import dumps

from knotfem.sources import sources

P = ParamSpec("P")
R = TypeVar("R")

_DAYS, _VERSIONS = 30, 10
"""For how long after its last use, and of how many versions of a module, machine code is kept."""
_SETTINGS = ("OPT", "BOUNDSCHECK", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "USING_SVML")
_log = logging.getLogger(__name__)


@overload
def kernel(function: Callable[P, R]) -> Callable[P, R]: ...
@overload
def kernel(
    *, parallel: bool = False, inline: str = "never", error_model: str = "python"
) -> Callable[[Callable[P, R]], Callable[P, R]]: ...
def kernel(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function when it is first called, and keep the machine code on disk.

    Args:
        function: to be compiled.
        **options: of `numba.njit`: `parallel`, `inline`, `error_model`.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(**options)(function)
        if isinstance(dispatcher, Dispatcher):  # not so with NUMBA_DISABLE_JIT
            cast(Any, dispatcher)._cache = _Cache(function)
        return dispatcher

    return compiled if function is None else compiled(function)


def wanted_folder() -> Path:
    """Where compiled kernels belong: below `NUMBA_CACHE_DIR`, else in the user's folder for caches."""
    told = os.environ.get("NUMBA_CACHE_DIR")
    if told:
        return Path(told).absolute() / "knotfem"
    from platformdirs import user_cache_path

    return user_cache_path("knotfem", appauthor=False) / "kernels"


def cache_folder() -> Path | None:
    """Where compiled kernels are: the wanted folder, a temporary one if that cannot be written, or nowhere."""
    return _usable(wanted_folder())


@cache
def _usable(wanted: Path) -> Path | None:
    try:
        _try(wanted)
        return wanted
    except OSError as error:
        problem = error
    user = os.getuid() if hasattr(os, "getuid") else "kernels"
    try:
        instead = Path(tempfile.gettempdir()) / f"knotfem-{user}"
        _try(instead, private=True)
    except OSError as error:
        _log.warning("compiled kernels cannot be kept (%s; %s)", problem, error)
        return None
    _log.warning("compiled kernels are kept in %s (%s)", instead, problem)
    return instead


def _try(folder: Path, private: bool = False) -> None:
    """Write to a folder; a private one must be the user's own, for whoever can write there can have code run."""
    folder.mkdir(mode=0o700 if private else 0o777, parents=True, exist_ok=True)
    found = folder.lstat()
    if private and hasattr(os, "getuid") and (found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) & 0o022):
        raise PermissionError(errno.EACCES, "others can write there", str(folder))
    tempfile.TemporaryFile(dir=folder).close()


class _Cache(FunctionCache):
    """Numba's cache of one function, with folder and files of its own, found when the function is first called."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = repr(function)
        self._py_func = function
        self._cache_file = _Files(function)
        self._impl = _Serialised(self._cache_file)
        self.enable()

    @property
    def cache_path(self) -> str | None:
        folder = self._cache_file.folder
        return None if folder is None else str(folder)


class _Serialised(CompileResultCacheImpl):
    def __init__(self, files: _Files) -> None:
        self._locator = files
        self._lineno = files.line


class _Files:
    """Machine code of one function: a file for each signature and processor, whole or not there.

    It stands in for both Numba's locator and its index. The index, one file for all signatures, does without: two
    processes that compile different signatures at once would each give theirs the same number, and the index could
    then name the machine code of the other signature.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._py_file = inspect.getfile(function)
        self.line = function.__code__.co_firstlineno

    @cached_property
    def folder(self) -> Path | None:
        module = sys.modules.get(self._function.__module__)
        spec = getattr(module, "__spec__", None)  # names the module that runs as __main__
        return _version_folder(spec.name if spec else str(self._function.__module__), self._py_file)

    def load(self, key: Any) -> Any:
        """What was saved under a key, or None."""
        if self.folder is None:
            return None
        try:
            data = self._file(self.folder, key).read_bytes()
        except OSError:
            return None
        digest, content = data[:32], data[32:]
        if hashlib.sha256(content).digest() != digest:  # cut short when the machine went down
            return None
        found, result = pickle.loads(content)
        return result if found == key else None

    def save(self, key: Any, result: Any) -> None:
        """Keep what `load` is to find; a full disk is no reason to stop."""
        if self.folder is None:
            return
        content = dumps((key, result))
        whole = self._file(self.folder, key)
        part = whole.with_name(f"{uuid.uuid4().hex}.part")
        try:
            if not self.folder.exists():
                self.folder.mkdir(parents=True, exist_ok=True)
                _remove_old(self.folder.parents[1])
            part.write_bytes(hashlib.sha256(content).digest() + content)
            part.replace(whole)
        except OSError as error:
            _log.debug("%s is not kept: %s", self._function, error)
            with suppress(OSError):
                part.unlink(missing_ok=True)

    def flush(self) -> None:
        """Forget every signature."""
        if self.folder is not None:
            for file in self.folder.glob(f"{self._stem}*"):
                file.unlink(missing_ok=True)

    def ensure_cache_path(self) -> None:
        """`save` makes the folder."""

    def _file(self, folder: Path, key: Any) -> Path:
        return folder / f"{self._stem}{_short_hash(repr((self._function.__module__, key)).encode())}.nbc"

    @property
    def _stem(self) -> str:
        return f"{self._function.__qualname__.replace('<', '').replace('>', '')}-{self.line}-"


def _version_folder(module: str, file: str) -> Path | None:
    """Folder of a module's machine code, of the present sources and libraries."""
    root = cache_folder()
    if root is None:
        return None
    try:
        texts = sources(module, Path(file))
    except (OSError, SyntaxError) as error:
        _log.debug("machine code of %s is not kept: %s", module, error)
        return None
    made_from = [_surroundings(), *((name, hashlib.sha256(texts[name]).hexdigest()) for name in sorted(texts))]
    folder = root / module / _short_hash(repr(made_from).encode())
    with suppress(OSError):
        os.utime(folder)  # the time of its last use
    return folder


def _surroundings() -> tuple[Any, ...]:
    """What machine code depends on beside sources, signature and processor."""
    versions = (numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag)
    return (*versions, platform.system(), *(getattr(config, name, None) for name in _SETTINGS))


@cache
def _remove_old(root: Path) -> None:
    """Remove machine code of old versions, whatever other processes do: who misses a file compiles, and writes anew."""
    oldest = time.time() - _DAYS * 86400
    for module in root.iterdir():
        with suppress(OSError):  # another process is removing it
            used = sorted(((folder.stat().st_mtime, folder) for folder in module.iterdir()), reverse=True)
            for place, (time_of_use, folder) in enumerate(used):
                if place >= _VERSIONS or time_of_use < oldest:
                    shutil.rmtree(folder, ignore_errors=True)
            if not any(module.iterdir()):
                module.rmdir()


def _short_hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:20]
