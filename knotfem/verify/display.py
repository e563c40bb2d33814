"""The table of verdicts on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from knotfem.verify.verdict import Verdict

if TYPE_CHECKING:
    from rich.table import Table

HEADS = ("case", "quantity", "expected (source)", "found", "deviation", "verdict", "s")


def show(verdicts: Sequence[Verdict]) -> None:
    """Print a row a quantity, and how many cases failed."""
    from rich.markup import escape
    from rich.table import Table

    page = Table(*HEADS)
    for verdict in verdicts:
        name, source, seconds = verdict.case.name, f" ({verdict.case.source})", f"{verdict.seconds:.1f}"
        for q in verdict.quantities:
            expected, found, deviation = q.shown
            what = f"{q.name}, {q.condition}" if q.condition else q.name
            page.add_row(name, escape(what), escape(expected + source), found, deviation, mark(q.passed), seconds)
            name = source = seconds = ""
        if verdict.error:
            page.add_row(name, escape(verdict.error), escape(source), "", "", mark(False), seconds)
        page.add_section()
    print_page(page, verdicts, width=150)


def print_page(page: Table, verdicts: Sequence[Verdict], *, width: int) -> None:
    """Print a table of verdicts, so wide where the terminal does not say, and how many cases failed."""
    from rich.console import Console

    failed = sum(not verdict.passed for verdict in verdicts)
    total = sum(verdict.seconds for verdict in verdicts)
    page.caption = f"{len(verdicts)} cases, {failed} failed, {total:.0f} s"
    console = Console()
    if not console.is_terminal:
        console = Console(width=width)
    console.print(page)


def mark(passed: bool) -> str:
    """A verdict in colour."""
    return "[green]pass[/]" if passed else "[bold red]FAIL[/]"
