"""What the doctor finds."""

import json

import pytest

from knotfem import doctor
from knotfem.errors import MissingDependency
from knotfem.plot import opengl
from knotfem.scene.control import Solver
from knotfem.sparse import linear


def test_facts_hold_in_json(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opengl, "find_window", lambda: None)
    monkeypatch.setattr(linear, "available", lambda: ["superlu"])
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    found = json.loads(json.dumps(doctor.describe()))
    assert found["linear solvers"]["auto takes"] == "superlu"
    assert "pip install mkl" in found["linear solvers"]["pardiso"]
    assert found["pictures"]["OpenGL off screen"].startswith("missing; cure: ")
    assert found["threads"]["OMP_NUM_THREADS"] == "3"
    assert found["threads"]["usable"] >= 1
    assert found["compiled kernels"]["folder"]


def test_a_solver_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear, "available", lambda: ["superlu"])
    doctor.require(Solver.model_validate({"linear": "auto"}))
    doctor.require(Solver.model_validate({"linear": "superlu"}))
    with pytest.raises(MissingDependency, match="pardiso is missing; cure"):
        doctor.require(Solver.model_validate({"linear": "pardiso"}))
