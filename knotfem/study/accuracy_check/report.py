"""What a search for an accuracy came to: as a block of summary.json, in words, and as a table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from knotfem.results.run import Run
from knotfem.study.accuracy_check.estimate import Change
from knotfem.study.accuracy_check.search import Found
from knotfem.study.tables import SHORT, duration

if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True, eq=False)
class CheckedAccuracy:
    """A run and the measured error of its settings.

    Attributes:
        run: with the settings that were found.
        target: largest relative error that was asked for.
        estimate: relative error of these settings; None where a choice was not measured.
        quantity: what the error is of, such as "force".
        changes: of each choice at these settings.
        ended: why the search ended before the target; "" where the target is reached.
        cpu_s: CPU seconds of all runs.
        folder: of these runs.
        start: from which settings the search set out, in words.
    """

    run: Run
    target: float
    estimate: float | None
    quantity: str
    changes: tuple[Change, ...]
    ended: str
    cpu_s: float
    folder: Path
    start: str

    @property
    def reached(self) -> bool:
        """Whether the estimate is within the target."""
        return not self.ended

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return in_words(self.target, self.estimate, self.quantity, self.ended, self.cpu_s)


def block_of(found: Found, target: float, folder: Path, start: str) -> dict[str, Any]:
    """The table `accuracy` of summary.json; the band is in N, of force curves only."""
    band = None if found.estimate is None or found.quantity != "force" else found.estimate * found.scale
    return {
        "target": target,
        "estimate": found.estimate,
        "reached": not found.ended,
        "ended": found.ended,
        "quantity": found.quantity,
        "band_N": band,
        "start": start,
        "level": found.level.name,
        "changes": [row_of(change) for change in found.changes],
        "not_checked": {change.choice: change.missing for change in found.changes if change.missing},
        "cpu_s": found.cpu_s,
        "folder": str(folder.resolve()),
    }


def row_of(change: Change) -> dict[str, Any]:
    """A choice as a row of a table."""
    return {
        "choice": change.choice,
        "from": change.before,
        "to": change.after,
        "change": change.change,
        "error": None if change.change is None else change.error,
        "cpu_s": change.cpu_s,
        "expected": change.expected,
    }


def in_words(target: float, estimate: float | None, quantity: str, ended: str, cpu_s: float) -> str:
    """Promised and measured, in one sentence."""
    asked = f"asked for {target:.2%} in the {SHORT[quantity]}"
    measured = "the error is not known" if estimate is None else f"measured {estimate:.2%}"
    why = f"; not within the target: {ended}" if ended else ""
    return f"{asked}, {measured}, {duration(cpu_s)} of CPU time for all runs{why}"


def table_of(checked: CheckedAccuracy) -> Table:
    """Choices, what finer settings change, and what they took, for a terminal."""
    from rich.table import Table

    table = Table("choice", "from", "to", "change, %", "error, %", "CPU s", title="settings and the next finer ones")
    for change in checked.changes:
        row = row_of(change)
        figures = ["-" if row[name] is None else f"{100.0 * row[name]:.2f}" for name in ("change", "error")]
        cpu = "-" if change.cpu_s is None else f"{change.cpu_s:.1f}"
        note = " (expected)" if change.expected else ""
        table.add_row(change.choice, change.before, change.after, figures[0] + note, figures[1], cpu)
    return table
