"""Names in any script: fonts that have their characters, and what no font of this machine has."""

from __future__ import annotations

import logging
import unicodedata
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

BOXES = "Last Resort"
"""Fonts that have a box for every character."""
_LOG = logging.getLogger("knotfem")


def literal(name: str) -> str:
    """A name as matplotlib shows it unchanged: no formula between dollar signs, no line that legends leave out.

    Args:
        name: of a run, a rod or a step.
    """
    escaped = name.replace("$", r"\$")
    return f" {escaped}" if escaped.startswith("_") else escaped


def use_fonts_for(figure: Any) -> None:
    """Give each text of a figure the fonts that have its characters; a log entry names those that none has.

    Args:
        figure: of matplotlib, complete.
    """
    from matplotlib.text import Text

    lacking: set[str] = set()
    for text in figure.findobj(Text):
        family, missing = fonts_for(frozenset(text.get_text()))
        if len(family) > 1:
            text.set_fontfamily(list(family))
        lacking |= missing
    if lacking:
        shown = "".join(sorted(lacking))
        _LOG.warning("no font of this machine has the characters %s of a name; boxes stand for them", shown)


@contextmanager
def without_glyph_warnings() -> Iterator[None]:
    """Leave out matplotlib's own warnings of missing characters."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"Glyph .* missing from (current )?font")
        yield


@cache
def fonts_for(characters: frozenset[str]) -> tuple[tuple[str, ...], frozenset[str]]:
    """Families of fonts that have characters, the usual one first, and the characters that none has."""
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties, findfont, fontManager

    usual = FontProperties(family=rcParams["font.family"])
    wanted = {character for character in characters if unicodedata.category(character) not in ("Cc", "Zs")}
    wanted -= _characters(findfont(usual))
    families: list[str] = list(rcParams["font.family"])
    for entry in fontManager.ttflist if wanted else ():
        found = set() if entry.name.startswith(BOXES) else wanted & _characters(entry.fname)
        if found:
            families.append(entry.name)
            wanted -= found
        if not wanted:
            break
    return tuple(families), frozenset(wanted)


@cache
def _characters(file: str) -> frozenset[str]:
    """Characters of a font's file; none of one that cannot be read."""
    from matplotlib.ft2font import FT2Font

    try:
        return frozenset(map(chr, FT2Font(file).get_charmap()))
    except (OSError, RuntimeError):
        return frozenset()
