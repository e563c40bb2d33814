"""Memory that this process takes."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path


def peak_memory_mb() -> float:
    """Most memory that this process has held [MB]."""
    if sys.platform == "win32":
        import psutil

        return psutil.Process().memory_info().peak_wset / 2**20
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20


def reset_peak_memory() -> None:
    """Let `peak_memory_mb` begin anew with what the process holds now, where the system can do so (Linux)."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
