"""The table of the hard cases on the terminal: a row a run, and a row each figure of its own."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.verify.display import mark, print_page
from knotfem.verify.verdict import Quantity, Verdict

COMMON = ("finished", "cutbacks", "smallest J", "penetration / d", "knot before", "knot after", "energy error")
"""Figures that have a column each."""
HEADS = ("case", *COMMON, "must", "found", "verdict", "wall, s")


def show(verdicts: Sequence[Verdict]) -> None:
    """Print the table, and how many cases failed."""
    from rich.markup import escape
    from rich.table import Table

    page = Table(*HEADS)
    for verdict in verdicts:
        name, seconds, passed = verdict.case.name, f"{verdict.seconds:.1f}", mark(verdict.passed)
        for condition, figures in runs(verdict.quantities).items():
            label = f"{name}, {condition}" if condition else name
            page.add_row(label, *(_column(figures, key) for key in COMMON), "", "", passed, seconds)
            seconds = passed = ""
        for q in verdict.quantities:
            if q.name not in COMMON:
                expected, found, deviation = q.shown
                must = f"{q.name}, {q.condition}: {expected}" if q.condition else f"{q.name}: {expected}"
                empty = [""] * (len(COMMON) + 1)
                page.add_row(*empty, escape(must), f"{found}, {deviation}" if deviation else found, mark(q.passed), "")
        if verdict.error:
            page.add_row(name, escape(verdict.error), *[""] * len(COMMON), "", mark(False), seconds)
        page.add_section()
    print_page(page, verdicts, width=200)


def runs(quantities: Sequence[Quantity]) -> dict[str, dict[str, Quantity]]:
    """The common figures of each run of a case, by what tells the runs apart."""
    found: dict[str, dict[str, Quantity]] = {}
    for q in quantities:
        if q.name in COMMON:
            found.setdefault(q.condition, {})[q.name] = q
    return found or {"": {}}


def _column(figures: dict[str, Quantity], name: str) -> str:
    if name not in figures:
        return "-"
    q = figures[name]
    found = q.shown[1]
    return found if q.passed else f"[bold red]{found}[/]"
