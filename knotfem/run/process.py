"""Which process computes a run, and whether it still does."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from typing import Any

SAME_START = 10.0
"""Two start times that differ by less are of one process [s]; clocks are set meanwhile, numbers are given anew."""


def this_process() -> dict[str, Any]:
    """Number and start of this process, and the machine that it runs on, for status.json."""
    import psutil

    return {"pid": os.getpid(), "process_started": psutil.Process().create_time(), "host": platform.node()}


def has_gone(status: Mapping[str, Any]) -> bool:
    """Whether the process of a status that says "running" is not there any more.

    Processes of other machines count as there, since nobody knows here.

    Args:
        status: of status.json.
    """
    import psutil

    if status.get("state") != "running" or status.get("host", platform.node()) != platform.node():
        return False
    try:
        process = psutil.Process(int(status["pid"]))
        if process.status() == psutil.STATUS_ZOMBIE:
            return True
        return abs(process.create_time() - float(status.get("process_started", process.create_time()))) > SAME_START
    except (KeyError, TypeError, ValueError, psutil.NoSuchProcess):
        return True
    except psutil.AccessDenied:
        return False
