"""The table of verdicts on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from knotfem.verify.verdict import Verdict

HEADS = ("case", "quantity", "expected (source)", "found", "deviation", "verdict", "s")


def show(verdicts: Sequence[Verdict]) -> None:
    """Print a row a quantity, and how many cases failed."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    page = Table(*HEADS)
    for verdict in verdicts:
        name, source, seconds = verdict.case.name, f" ({verdict.case.source})", f"{verdict.seconds:.1f}"
        for q in verdict.quantities:
            expected, found, deviation = q.shown
            what = f"{q.name}, {q.condition}" if q.condition else q.name
            page.add_row(name, escape(what), escape(expected + source), found, deviation, _mark(q.passed), seconds)
            name = source = seconds = ""
        if verdict.error:
            page.add_row(name, escape(verdict.error), escape(source), "", "", _mark(False), seconds)
        page.add_section()
    failed = sum(not verdict.passed for verdict in verdicts)
    total = sum(verdict.seconds for verdict in verdicts)
    page.caption = f"{len(verdicts)} cases, {failed} failed, {total:.0f} s"
    console = Console()
    if not console.is_terminal:
        console = Console(width=150)
    console.print(page)


def _mark(passed: bool) -> str:
    return "[green]pass[/]" if passed else "[bold red]FAIL[/]"
