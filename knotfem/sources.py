"""Sources that a module is made from: its own text and that of all that it imports from its package."""

from __future__ import annotations

import ast
import gc
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.util import resolve_name
from pathlib import Path

_STARTED = time.time() - time.thread_time()
"""About when this process began, or this program in it; nothing was imported much before."""


def sources(module: str, file: Path) -> dict[str, bytes]:
    """Text by name of a module and of all that it imports, in the end, from its own package or from this one.

    Raises:
        OSError: one cannot be read, or has changed since this process began, which may have imported the old text.
    """
    packages = {module.partition(".")[0], __name__.partition(".")[0]}
    found: dict[str, bytes] = {}
    ahead = {module: file}
    while ahead:
        name, file = ahead.popitem()
        changed = file.stat().st_mtime
        if _STARTED < changed <= time.time():
            raise OSError(f"{file} has changed since this process began")
        found[name], imports = _read(name, file, changed)
        for other in imports:
            if other.partition(".")[0] in packages and other not in found and (place := _find(other)):
                ahead[other] = place
    return found


@cache
def _read(name: str, file: Path, changed: float) -> tuple[bytes, frozenset[str]]:
    """Text of a module and the names of what it imports."""
    text = file.read_bytes()
    if file.stat().st_mtime != changed:
        raise OSError(f"{file} is changing")
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    collects = gc.isenabled()
    gc.disable()  # else the many nodes have it go through all that is imported, ten times as long as the parsing
    try:
        return text, frozenset(_imports(ast.parse(text), package))
    finally:
        if collects:
            gc.enable()


def _imports(tree: ast.AST, package: str) -> Iterator[str]:
    """Names of modules that are imported at module level, and names from these, which may be modules too."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                parts = alias.name.split(".")
                yield from (".".join(parts[: count + 1]) for count in range(len(parts)))
        elif isinstance(node, ast.ImportFrom):
            with suppress(ImportError):  # a relative import in what is no package
                module = resolve_name("." * node.level + (node.module or ""), package)
                yield module
                yield from (f"{module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from _imports(ast.Module(node.orelse, []), package)
        elif isinstance(node, ast.stmt | ast.excepthandler) and not isinstance(
            node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
        ):
            yield from _imports(node, package)


@cache
def _find(name: str) -> Path | None:
    """File of a module of a package that is imported."""
    top, *rest = name.split(".")
    for folder in getattr(sys.modules.get(top), "__path__", ()):
        place = Path(folder, *rest)
        for file in (place / "__init__.py", place.with_name(f"{place.name}.py")):
            if file.is_file():
                return file
    return None
