"""Memory that a process has held, in the units of each system."""

import sys
from types import SimpleNamespace

import psutil
import pytest

from knotfem.run.memory_use import peak_memory_mb


@pytest.mark.parametrize(("system", "expected"), [("linux", 2048.0), ("darwin", 2.0)])
def test_peak_memory_in_the_units_of_each_system(monkeypatch: pytest.MonkeyPatch, system: str, expected: float) -> None:
    usage = SimpleNamespace(RUSAGE_SELF=0, getrusage=lambda who: SimpleNamespace(ru_maxrss=2**21))
    monkeypatch.setitem(sys.modules, "resource", usage)
    monkeypatch.setattr(sys, "platform", system)
    assert peak_memory_mb() == expected


def test_peak_memory_where_there_is_no_module_resource(monkeypatch: pytest.MonkeyPatch) -> None:
    process = SimpleNamespace(memory_info=lambda: SimpleNamespace(peak_wset=2**21))
    monkeypatch.setitem(sys.modules, "resource", None)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(psutil, "Process", lambda: process)
    assert peak_memory_mb() == 2.0
