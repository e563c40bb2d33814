"""Names that a user may have mistyped."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def suggestion(name: str, known: Iterable[str]) -> str:
    """What a message says that it expected: the closest known name first, then the others."""
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    others = ", ".join(other for other in names if other not in close)
    if not close:
        return f"one of {others}" if others else "none, there are no names"
    return f'"{close[0]}", or one of {others}' if others else f'"{close[0]}"'
