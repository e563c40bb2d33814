"""Progress of a run: a live bar on a terminal, lines once in a while elsewhere, JSON lines, or nothing."""

from __future__ import annotations

import json
import logging
import math
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import IO, Literal, Protocol

from knotfem.run.step_figures import StepReport, figures

LogFormat = Literal["text", "json"]
LINE = 132
"""Characters in a line where nobody says how many there are."""
EVERY = 30.0
"""Longest time between two lines of a run that goes on [s]; steps at which an output is due have one anyway."""
BAR = 8 + 1 + 10 + 1
"""Characters of a live bar and the name of its phase."""


class Progress(Protocol):
    """What the driver tells about a run; close it at the end, also after an error."""

    def message(self, text: str) -> None:
        """Say one thing, such as that kernels are being compiled."""
        ...

    def step(self, report: StepReport) -> None:
        """Tell of an accepted step."""
        ...

    def close(self) -> None:
        """Give the terminal back."""
        ...


class Silent:
    """Says nothing."""

    def message(self, text: str) -> None:
        """Say nothing."""

    def step(self, report: StepReport) -> None:
        """Say nothing."""

    def close(self) -> None:
        """Do nothing."""


class Unfailing:
    """Falls silent where its stream cannot be written any more, as after a terminal has closed; the run goes on.

    Args:
        progress: what tells.

    Attributes:
        inner: the same, or `Silent` once it cannot be written.
    """

    def __init__(self, progress: Progress) -> None:
        self.inner = progress

    def message(self, text: str) -> None:
        """Say one thing."""
        with self._silent_if_broken():
            self.inner.message(text)

    def step(self, report: StepReport) -> None:
        """Tell of an accepted step."""
        with self._silent_if_broken():
            self.inner.step(report)

    def close(self) -> None:
        """Give the terminal back."""
        with self._silent_if_broken():
            self.inner.close()

    @contextmanager
    def _silent_if_broken(self) -> Iterator[None]:
        try:
            yield
        except OSError:
            self.inner = Silent()


class JsonLines:
    """A JSON object a line."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream, self._clock = stream, _Clock()

    def message(self, text: str) -> None:
        """Write {"message": ...}."""
        self._write({"message": text})

    def step(self, report: StepReport) -> None:
        """Write the step with its unit-bearing names."""
        left = self._clock.time_left(report)
        fields = {name: value for name, value in asdict(report).items() if name not in ("kind", "stretch", "due")}
        fields["time_left"] = left
        named = {_JSON_NAMES.get(name, name): value for name, value in fields.items()}
        self._write(
            {name: None if isinstance(value, float) and math.isnan(value) else value for name, value in named.items()}
        )

    def close(self) -> None:
        """Do nothing."""

    def _write(self, record: dict[str, object]) -> None:
        print(json.dumps(record), file=self._stream, flush=True)


class Lines:
    """A line of text where a phase begins, at each output, and once in a while between them."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream, self._clock, self._pace = stream, _Clock(), _Pace()

    def message(self, text: str) -> None:
        """Write the text."""
        print(text, file=self._stream, flush=True)

    def step(self, report: StepReport) -> None:
        """Write the step's figures, if it is time to."""
        left = self._clock.time_left(report)
        if not self._pace.due(report):
            return
        done = "" if math.isnan(report.fraction) else f"{100.0 * report.fraction:5.1f} %  "
        head = f"{report.phase:<8} {done}{_left(left)}"
        width = int(os.environ["COLUMNS"]) if os.environ.get("COLUMNS", "").isdecimal() else LINE
        print(head + figures(report, width - len(head)), file=self._stream, flush=True)

    def close(self) -> None:
        """Do nothing."""


class LiveBar:
    """A bar that is redrawn in place; one bar a phase."""

    def __init__(self, stream: IO[str]) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn
        from rich.table import Column

        columns = (
            TextColumn("{task.description}", table_column=Column(min_width=8, no_wrap=True)),
            BarColumn(bar_width=10, table_column=Column(min_width=10)),
            TextColumn("{task.fields[figures]}", table_column=Column(ratio=1, no_wrap=True)),
        )
        self._bar = Progress(
            *columns, console=Console(file=None if in_notebook() else stream), refresh_per_second=4, expand=True
        )
        self._clock, self._phase, self._task = _Clock(), "", None

    def message(self, text: str) -> None:
        """Write the text above the bar."""
        self._bar.console.print(text, markup=False, highlight=False)

    def step(self, report: StepReport) -> None:
        """Redraw; the first step shows the bar."""
        self._bar.start()
        left = self._clock.time_left(report)
        if self._task is None or report.phase != self._phase:
            self._finish_phase()
            self._phase, self._task = report.phase, self._bar.add_task(report.phase, total=None, figures="")
        known = not math.isnan(report.fraction)
        self._bar.update(
            self._task,
            total=1.0 if known else None,
            completed=report.fraction if known else 0.0,
            figures=_left(left) + figures(report, self._bar.console.width - BAR - len(_left(left))),
        )

    def close(self) -> None:
        """Stop redrawing."""
        self._bar.stop()

    def _finish_phase(self) -> None:
        if self._task is not None:
            self._bar.update(self._task, total=1.0, completed=1.0)


def make_progress(*, quiet: bool = False, log_format: LogFormat = "text", stream: IO[str] | None = None) -> Progress:
    """The kind of progress that fits.

    Args:
        quiet: say nothing.
        log_format: "json" for JSON lines.
        stream: where to; standard error by default, a live bar if it is a terminal.
    """
    target = stream or sys.stderr
    if quiet or target is None:
        return Silent()
    if log_format == "json":
        return Unfailing(JsonLines(target))
    return Unfailing(LiveBar(target) if target.isatty() else Lines(target))


class Logged:
    """Records of the log "knotfem", as often as `Lines`, for programs that have no terminal."""

    def __init__(self) -> None:
        self._log, self._pace = logging.getLogger("knotfem"), _Pace()

    def message(self, text: str) -> None:
        """Log the text."""
        self._log.info(text)

    def step(self, report: StepReport) -> None:
        """Log the step's figures, if it is time to."""
        if not self._pace.due(report):
            return
        self._log.info("%s  %s", report.phase, figures(report))

    def close(self) -> None:
        """Do nothing."""


def automatic_progress(*, shown: bool = True) -> Progress:
    """A bar where a person looks on, in a terminal or a notebook; else records of the log.

    Args:
        shown: false for the log alone.
    """
    stream = sys.stderr
    if shown and (in_notebook() or (stream is not None and stream.isatty())):
        return LiveBar(stream)
    return Logged()


def in_notebook() -> bool:
    """Whether a notebook shows what is told."""
    shell = sys.modules.get("IPython")
    instance = shell.get_ipython() if shell is not None else None
    return type(instance).__name__ == "ZMQInteractiveShell"


class _Clock:
    """Time left in a phase, from the fraction done since the phase began."""

    def __init__(self) -> None:
        self._phase, self._start, self._fraction = "", 0.0, 0.0

    def time_left(self, report: StepReport) -> float:
        now = time.monotonic()
        if report.phase != self._phase:
            self._phase, self._start, self._fraction = report.phase, now, report.fraction
        done = report.fraction - self._fraction
        return (now - self._start) * (1.0 - report.fraction) / done if done > 0.0 else math.nan


class _Pace:
    """Says of which steps there is a line."""

    def __init__(self) -> None:
        self._phase, self._told = "", -math.inf

    def due(self, report: StepReport) -> bool:
        """Whether a step is the first of its phase, has an output, or comes `EVERY` seconds after the last line."""
        now = time.monotonic()
        if report.phase == self._phase and not report.due and now - self._told < EVERY:
            return False
        self._phase, self._told = report.phase, now
        return True


def _left(seconds: float) -> str:
    return "" if math.isnan(seconds) else f"{clock(seconds)} left  "


def clock(seconds: float) -> str:
    """A time as a clock shows it."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


_JSON_NAMES = {
    "time": "time_s",
    "displacement": "displacement_mm",
    "force": "force_N",
    "penetration": "max_penetration_mm",
    "iterations": "newton_iterations",
    "time_left": "time_left_s",
}
