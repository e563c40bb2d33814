"""Text for a terminal: names and values in the width that there is."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from collections.abc import Mapping
from typing import IO, Any

UNITS = {"mb": "MB", "gb": "GB", "s": "s", "N": "N", "mm": "mm", "Nmm": "N mm"}
"""Units at the end of names in files, as a reader writes them."""
NAMES = {
    "max_stretch_deviation": "largest |stretch - 1| while mapped",
    "expected_memory_mb_of_a_run": "expected memory of a run [MB]",
}
"""Names whose parts do not say what they are."""
WORDS = {
    "dofs": "degrees of freedom",
    "events": "jumps",
    "hexes": "hexahedra",
    "cutbacks": "shortened steps",
    "max": "largest",
    "min": "smallest",
    "cpu": "CPU",
}
"""Parts of names in files, in words."""
NARROWEST = 40
"""Lines are never made shorter."""


class Sentences(tuple[str, ...]):
    """Texts of which each begins a line of its own."""


def width_of(stream: IO[str] | None = None) -> int | None:
    """Characters in a line: what COLUMNS says or the terminal has; None where lines may have any length.

    Args:
        stream: standard output unless given.
    """
    target = sys.stdout if stream is None else stream
    if not os.environ.get("COLUMNS", "").isdecimal() and not target.isatty():
        return None
    return max(NARROWEST, shutil.get_terminal_size().columns)


def spoken(name: str) -> str:
    """A name from a file as a reader would write it: "max_penetration_over_d" is "largest penetration over d"."""
    if name in NAMES:
        return NAMES[name]
    parts = name.split("_")
    unit = f" [{UNITS[parts.pop()]}]" if len(parts) > 1 and parts[-1] in UNITS else ""
    return " ".join(WORDS.get(part, part) for part in parts) + unit


def facts(values: Mapping[str, Any], indent: str = "", *, width: int | None = None) -> str:
    """Lines of names and values, tables below their name; long values go on below themselves.

    Args:
        values: by name.
        indent: before each line.
        width: of a line; None for any.
    """
    longest = max((len(key) for key, value in values.items() if not _is_table(value)), default=0)
    column = longest if width is None else min(longest, width // 2 - len(indent))
    lines: list[str] = []
    for key, value in values.items():
        if _is_table(value):
            lines += [f"{indent}{key}", facts(value, indent + "  ", width=width)]
        elif isinstance(value, Sentences) and value:
            lines.append(f"{indent}{key}")
            for text in value:
                lines += wrapped(text, width, indent + "  ", hanging=indent + "    ")
        else:
            lines += _entry(key, shown(value), indent, column, width)
    return "\n".join(lines)


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) and bool(value)


def _entry(key: str, text: str, indent: str, column: int, width: int | None) -> list[str]:
    head = f"{indent}{key:<{column}}  "
    if width is None or len(head) + len(text) <= width:
        return [head + text]
    hanging = indent + " " * (column + 2)
    if len(key) > column:
        return [indent + key, *wrapped(text, width, hanging)]
    return textwrap.wrap(text, width, initial_indent=head, subsequent_indent=hanging, break_on_hyphens=False)


def wrapped(text: str, width: int | None, indent: str = "", hanging: str | None = None) -> list[str]:
    """Lines of a text of at most a width; words that are longer, such as paths, are not broken.

    Args:
        text: one paragraph.
        width: of a line; None for any.
        indent: before each line.
        hanging: before the second and further lines instead.
    """
    if width is None:
        return [indent + text]
    return textwrap.wrap(
        text,
        width,
        initial_indent=indent,
        subsequent_indent=indent if hanging is None else hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )


def shown(value: object) -> str:
    """A value as text."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list | tuple | dict):
        return ", ".join(map(str, value)) or "none"
    return "-" if value is None else str(value)
