"""Progress of a study: points done, running, failed, time left."""

from __future__ import annotations

import json
import logging
import math
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from typing import IO, Protocol

from knotfem.run.progress import clock, in_notebook

LINES_EVERY = 30.0
"""Seconds between lines where nothing ends."""


@dataclass(frozen=True)
class Tally:
    """How far a study is.

    Attributes:
        points: of the study.
        done: with results.
        failed: without; a result too.
        running: now.
        left_s: expected seconds until all are through; NaN where nobody knows.
    """

    points: int
    done: int = 0
    failed: int = 0
    running: int = 0
    left_s: float = math.nan

    def __str__(self) -> str:
        left = (
            "" if math.isnan(self.left_s) or self.done + self.failed == self.points else f", {clock(self.left_s)} left"
        )
        return f"{self.done} of {self.points} points done, {self.running} running, {self.failed} failed{left}"


class StudyProgress(Protocol):
    """What is told of a study; close it at the end, also after an error."""

    def message(self, text: str) -> None:
        """Say one thing."""
        ...

    def update(self, tally: Tally) -> None:
        """Show how far the study is; called several times a second."""
        ...

    def close(self) -> None:
        """Give the terminal back."""
        ...


class SilentStudy:
    """Says nothing."""

    def message(self, text: str) -> None:
        """Say nothing."""

    def update(self, tally: Tally) -> None:
        """Say nothing."""

    def close(self) -> None:
        """Do nothing."""


class LoggedStudy:
    """Records of the log "knotfem", for programs that have no terminal."""

    def __init__(self) -> None:
        self._log, self._pace = logging.getLogger("knotfem"), _Pace()

    def message(self, text: str) -> None:
        """Log the text."""
        self._log.info(text)

    def update(self, tally: Tally) -> None:
        """Log the state once in a while."""
        if self._pace.due(tally):
            self._log.info("%s", tally)

    def close(self) -> None:
        """Do nothing."""


class StudyLines:
    """Lines of text, or of JSON."""

    def __init__(self, stream: IO[str], *, as_json: bool) -> None:
        self._stream, self._as_json, self._pace = stream, as_json, _Pace()

    def message(self, text: str) -> None:
        """Write the text, or {"message": ...}."""
        self._write({"message": text}, text)

    def update(self, tally: Tally) -> None:
        """Write the state when a point has ended, and once in a while."""
        if self._pace.due(tally):
            fields = asdict(tally) | {"left_s": None if math.isnan(tally.left_s) else round(tally.left_s, 1)}
            self._write(fields, str(tally))

    def close(self) -> None:
        """Do nothing."""

    def _write(self, record: Mapping[str, object], text: str) -> None:
        print(json.dumps(record) if self._as_json else text, file=self._stream, flush=True)


class StudyBar:
    """A bar that is redrawn in place."""

    def __init__(self, stream: IO[str] | None) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        columns = (BarColumn(bar_width=20), TextColumn("{task.description}"))
        self._bar = Progress(*columns, console=Console(file=stream), refresh_per_second=4)
        self._task = None

    def message(self, text: str) -> None:
        """Write the text above the bar."""
        self._bar.console.print(text, markup=False, highlight=False)

    def update(self, tally: Tally) -> None:
        """Redraw the bar."""
        if self._task is None:
            self._bar.start()
            self._task = self._bar.add_task(str(tally), total=tally.points)
        self._bar.update(self._task, completed=tally.done + tally.failed, description=str(tally))

    def close(self) -> None:
        """Stop redrawing."""
        self._bar.stop()


def study_progress(*, quiet: bool = False, log_format: str | None = None) -> StudyProgress:
    """Progress on standard error.

    Args:
        quiet: says nothing.
        log_format: "text" or "json" of a command; None for a program, whose log is told where no person looks on.
    """
    if quiet:
        return SilentStudy()
    stream = sys.stderr
    if log_format == "json" and stream is not None:
        return StudyLines(stream, as_json=True)
    if in_notebook():
        return StudyBar(None)
    if stream is not None and stream.isatty():
        return StudyBar(stream)
    return LoggedStudy() if log_format is None or stream is None else StudyLines(stream, as_json=False)


@contextmanager
def showing(progress: StudyProgress | bool) -> Iterator[StudyProgress]:
    """Progress of a call from Python, closed at its end.

    Args:
        progress: whether to show it, or an object that is told.
    """
    shown = study_progress(quiet=not progress) if isinstance(progress, bool) else progress
    with closing(shown):
        yield shown


class _Pace:
    """When a line is due: where a point has ended, and once in a while."""

    def __init__(self) -> None:
        self._ended, self._told = -1, float("-inf")

    def due(self, tally: Tally) -> bool:
        ended, now = tally.done + tally.failed, time.monotonic()
        if ended == self._ended and now - self._told < LINES_EVERY:
            return False
        self._ended, self._told = ended, now
        return True
