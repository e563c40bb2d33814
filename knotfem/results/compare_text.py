"""A comparison as text: a column for each run where there is room, else a line for each run."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from knotfem.results.compare import RELATIVE, Cell, Figure

LARGE = 10.0
"""Relative differences from here on are said as multiples."""
LONGEST_LABEL = 24
"""Of a run, in lines; of longer labels the end is shown."""
GAP = "  "
WITH_UNIT = ("mm", "N", "s")


def comparison_text(labels: Sequence[str], figures: Sequence[Figure], width: int | None = None) -> str:
    """Figures of several runs in a table.

    Args:
        labels: of the runs.
        figures: what is compared.
        width: characters in a line; None for any.
    """
    rows = [["", *labels], *([_named(f.name, f.unit), *(cell_text(c, f.unit) for c in f.cells)] for f in figures)]
    lines = _aligned(rows)
    if width is None or len(lines[0]) <= width:
        return "\n".join(lines)
    alike = [f for f in figures if len(set(f.cells)) == 1]
    said = "; ".join(f"{f.name} {cell_text(f.cells[0], f.unit)} {f.unit if f.unit in WITH_UNIT else ''}".rstrip()
                     for f in alike if f.cells[0] is not None)  # fmt: skip
    blocks = _blocks(labels, [f for f in figures if f not in alike], width)
    same = ["\n".join(textwrap.wrap(f"the same for all: {said}", width))] if said else []
    return "\n\n".join([*("\n".join(_aligned(block)) for block in blocks), *same])


def cell_text(value: Cell, unit: str) -> str:
    """A cell of a table."""
    if not isinstance(value, float):
        return "-" if value is None else str(value)
    if unit != RELATIVE:
        return f"{value:.4g}"
    return f"{100.0 * value:.2f} %" if abs(value) < LARGE else f"{value:.3g} times"


def _blocks(labels: Sequence[str], figures: Sequence[Figure], width: int) -> list[list[list[str]]]:
    """Tables with a line for each run, each as wide as fits."""
    first = ["", *(_end_of(label) for label in labels)]
    columns = [[_named(f.short or f.name, f.unit), *(cell_text(cell, f.unit) for cell in f.cells)] for f in figures]
    blocks: list[list[list[str]]] = []
    left = 0
    for column in columns:
        room = max(map(len, column)) + len(GAP)
        if not blocks or left < room:
            blocks.append([first])
            left = width - max(map(len, first))
        blocks[-1].append(column)
        left -= room
    return [[list(row) for row in zip(*block, strict=True)] for block in blocks]


def _end_of(label: str) -> str:
    return label if len(label) <= LONGEST_LABEL else "..." + label[3 - LONGEST_LABEL :]


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit in WITH_UNIT else name


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        GAP.join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))])
        for row in rows
    ]
