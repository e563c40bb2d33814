"""What the doctor finds."""

import json
import sys
from types import SimpleNamespace

import psutil
import pytest

from knotfem import doctor as machine
from knotfem.errors import MissingDependency
from knotfem.plot import opengl
from knotfem.scene.control import Solver
from knotfem.sparse import linear


def test_facts_hold_in_json(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opengl, "find_window", lambda: None)
    monkeypatch.setattr(linear, "available", lambda: ["superlu"])
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    found = json.loads(json.dumps(machine.describe()))
    assert found["linear solvers"]["auto takes"] == "superlu"
    assert "pip install mkl" in found["linear solvers"]["pardiso"]
    assert found["pictures"]["OpenGL off screen"].startswith("missing; cure: ")
    assert found["threads"]["OMP_NUM_THREADS"] == "3"
    assert found["threads"]["usable"] >= 1
    assert found["compiled kernels"]["folder"]


@pytest.mark.parametrize(("system", "expected"), [("linux", 2048.0), ("darwin", 2.0)])
def test_peak_memory_in_the_units_of_each_system(monkeypatch: pytest.MonkeyPatch, system: str, expected: float) -> None:
    usage = SimpleNamespace(RUSAGE_SELF=0, getrusage=lambda who: SimpleNamespace(ru_maxrss=2**21))
    monkeypatch.setitem(sys.modules, "resource", usage)
    monkeypatch.setattr(sys, "platform", system)
    assert machine.peak_memory_mb() == expected


def test_peak_memory_where_there_is_no_module_resource(monkeypatch: pytest.MonkeyPatch) -> None:
    process = SimpleNamespace(memory_info=lambda: SimpleNamespace(peak_wset=2**21))
    monkeypatch.setitem(sys.modules, "resource", None)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(psutil, "Process", lambda: process)
    assert machine.peak_memory_mb() == 2.0


def test_a_solver_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear, "available", lambda: ["superlu"])
    machine.require(Solver.model_validate({"linear": "auto"}))
    machine.require(Solver.model_validate({"linear": "superlu"}))
    with pytest.raises(MissingDependency, match="pardiso is missing; cure"):
        machine.require(Solver.model_validate({"linear": "pardiso"}))
