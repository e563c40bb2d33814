"""The table of results on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from knotfem.verify.case import Result

if TYPE_CHECKING:
    from rich.table import Table

HEADS = ("case", "quantity", "expected (source)", "found", "deviation", "result", "s")


def show(results: Sequence[Result]) -> None:
    """Print one row for each quantity, and how many cases failed."""
    from rich.markup import escape
    from rich.table import Table

    page = Table(*HEADS)
    for result in results:
        name, source, seconds = result.case.name, f" ({result.case.source})", f"{result.seconds:.1f}"
        for q in result.quantities:
            expected, found, deviation = q.shown
            what = f"{q.name}, {q.condition}" if q.condition else q.name
            page.add_row(name, escape(what), escape(expected + source), found, deviation, mark(q.passed), seconds)
            name = source = seconds = ""
        if result.error:
            page.add_row(name, escape(result.error), escape(source), "", "", mark(False), seconds)
        page.add_section()
    print_page(page, results, width=150)


def print_page(page: Table, results: Sequence[Result], *, width: int) -> None:
    """Print a table of results, and how many cases failed; without a terminal the table is `width` characters wide."""
    from rich.console import Console

    failed = sum(not result.passed for result in results)
    total = sum(result.seconds for result in results)
    page.caption = f"{len(results)} cases, {failed} failed, {total:.0f} s"
    console = Console()
    if not console.is_terminal:
        console = Console(width=width)
    console.print(page)


def mark(passed: bool) -> str:
    """Pass or fail, in colour."""
    return "[green]pass[/]" if passed else "[bold red]FAIL[/]"
