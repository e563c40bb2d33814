"""The table of the hard cases on the terminal: one row for each run, and one for each figure that only its case has."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.verify.case import Quantity, Result
from knotfem.verify.display import mark, print_page

COMMON = ("finished", "cutbacks", "smallest J", "penetration / d", "knot before", "knot after", "energy error")
"""Figures that have a column of their own."""
HEADS = ("case", *COMMON, "must", "found", "result", "wall, s")


def show(results: Sequence[Result]) -> None:
    """Print the table, and how many cases failed."""
    from rich.markup import escape
    from rich.table import Table

    page = Table(*HEADS)
    for result in results:
        name, seconds, passed = result.case.name, f"{result.seconds:.1f}", mark(result.passed)
        for condition, figures in runs(result.quantities).items():
            label = f"{name}, {condition}" if condition else name
            page.add_row(label, *(_column(figures, key) for key in COMMON), "", "", passed, seconds)
            seconds = passed = ""
        for q in result.quantities:
            if q.name not in COMMON:
                expected, found, deviation = q.shown
                must = f"{q.name}, {q.condition}: {expected}" if q.condition else f"{q.name}: {expected}"
                empty = [""] * (len(COMMON) + 1)
                page.add_row(*empty, escape(must), f"{found}, {deviation}" if deviation else found, mark(q.passed), "")
        if result.error:
            page.add_row(name, escape(result.error), *[""] * len(COMMON), "", mark(False), seconds)
        page.add_section()
    print_page(page, results, width=200)


def runs(quantities: Sequence[Quantity]) -> dict[str, dict[str, Quantity]]:
    """The common figures of each run of a case, by what distinguishes the runs."""
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
