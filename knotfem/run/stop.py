"""Ending a run in order: signals, the time limit and other threads set a flag that the run polls."""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType, TracebackType
from typing import Any, Self

from knotfem.errors import Interrupted, KnotfemError, Stopped

SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGINT", "SIGHUP") if hasattr(signal, name))
"""Requests to stop; Windows has no SIGHUP, which a terminal sends when it closes."""


class StopRequest:
    """While entered, takes SIGTERM, SIGHUP and Ctrl-C as a request to stop; a second Ctrl-C interrupts at once.

    A SIGHUP that is ignored, as after `nohup`, stays so.
    Outside the main thread signals are left alone; only the time limit and what another thread asks for count.
    """

    def __init__(self, time_limit: float | None = None, asked: threading.Event | None = None) -> None:
        """Set up.

        Args:
            time_limit: wall time after entering [s], or none.
            asked: set by another thread that asks to stop, or none.
        """
        self._limit, self._deadline = time_limit, float("inf")
        self._asked = asked or threading.Event()
        self._signal: int | None = None
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> Self:
        if self._limit is not None:
            self._deadline = time.monotonic() + self._limit
        if threading.current_thread() is threading.main_thread():
            self._previous = {number: signal.signal(number, self._note) for number in SIGNALS if not _ignored(number)}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    @property
    def due(self) -> bool:
        """Whether the run is to stop."""
        return self._signal is not None or self._asked.is_set() or time.monotonic() >= self._deadline

    def error(self, kept: str = "a checkpoint is written, go on with knotfem resume") -> KnotfemError:
        """What to raise, once the checkpoint is written if there is to be one."""
        if self._signal == signal.SIGINT:
            return Interrupted(f"interrupted; {kept}")
        asked = self._signal is not None or self._asked.is_set()
        reason = "asked to stop" if asked else "the time limit is reached"
        return Stopped(f"{reason}; {kept}")

    def _note(self, number: int, frame: FrameType | None) -> None:
        if number == signal.SIGINT and self._signal == signal.SIGINT:
            raise KeyboardInterrupt
        self._signal = number


def _ignored(number: int) -> bool:
    """Whether whoever started the process wants it to live through a closed terminal."""
    return number == getattr(signal, "SIGHUP", None) and signal.getsignal(number) == signal.SIG_IGN
