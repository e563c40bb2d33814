"""Provenance: what made a run, session by session."""

import json
import sys
from datetime import datetime
from pathlib import Path

import pytest

import knotfem
from knotfem.run.provenance import Provenance, library_versions


def read(folder: Path) -> dict:
    return json.loads((folder / "provenance.json").read_text())


def test_a_session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["knotfem", "pull", "bowline"])
    provenance = Provenance(tmp_path)
    assert provenance.additions is None
    provenance.begin(threads=2, additions={"terms": ["wind"]})
    assert read(tmp_path)["end"] is None
    provenance.note(linear_solver="pardiso")
    provenance.finish("done")
    facts = read(tmp_path)
    assert (facts["threads"], facts["linear_solver"], facts["exit_reason"]) == (2, "pardiso", "done")
    assert "seed" in facts
    assert facts["seed"] is None
    assert facts["command"] == ["knotfem", "pull", "bowline"]
    assert Provenance(tmp_path).additions == facts["additions"] == {"terms": ["wind"]}
    assert facts["versions"] == library_versions()
    assert datetime.fromisoformat(facts["start"]) <= datetime.fromisoformat(facts["end"])


def test_a_resumed_run_keeps_its_start(tmp_path: Path) -> None:
    first = Provenance(tmp_path)
    first.begin(threads=2, additions={"terms": ["wind"]})
    first.note(linear_solver="pardiso")
    start = read(tmp_path)["start"]
    first.finish("stopped")
    second = Provenance(tmp_path)
    second.begin(threads=1, additions={})
    second.note(linear_solver="superlu")
    second.finish("done")
    facts = read(tmp_path)
    assert facts["start"] == start
    assert (facts["linear_solver"], facts["exit_reason"]) == ("superlu", "done")
    assert [session["exit_reason"] for session in facts["sessions"]] == ["stopped", "done"]
    assert [session["threads"] for session in facts["sessions"]] == [2, 1]


def test_versions() -> None:
    versions = library_versions()
    assert versions["knotfem"] == knotfem.__version__
    assert {"python", "numpy", "scipy", "numba", "h5py"} <= set(versions)
