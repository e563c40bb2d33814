"""`knotfem verify`: table, files and exit codes, with cases made up for the purpose."""

import csv
import json
import os
import signal
from pathlib import Path

import pytest
from click.testing import CliRunner

from knotfem.errors import Interrupted, KnotfemError, NotConverged, Stopped
from knotfem.verify import suite
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress import suite as hard
from knotfem_cli.verify import verify


def right() -> list[Quantity]:
    return [Quantity("force [N]", 1.004, 1.0, 0.01), Quantity("gap [mm]", 0.1, 0.2, kind="at most")]


def wrong() -> list[Quantity]:
    return [Quantity("force [N]", 1.02, 1.0, 0.01)]


def fails() -> list[Quantity]:
    raise NotConverged("no balance [found]")


def pulled() -> list[Quantity]:
    return [
        Quantity("finished", "yes", "yes", kind="equal"),
        Quantity("smallest J", 0.7, 0.05, kind="at least"),
        *right(),
    ]


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    hard_ones = {
        True: [Case("rough", pulled, "a small knot", "hard cases")],
        False: [Case("rough", wrong, "a knot", "hard cases")],
    }
    cases = [
        Case("one", right, "right", "a book", "a mesh", "a"),
        Case("one", wrong, "wrong", "a book", "a mesh", "b"),
        Case("two", fails, "fails", "a book"),
    ]
    monkeypatch.setattr(suite, "closed_forms", lambda: cases)
    monkeypatch.setattr(hard, "hard_cases", lambda *, small: hard_ones[small])


def test_all_green() -> None:
    result = CliRunner().invoke(verify, ["--only", "one:a"])
    assert result.exit_code == 0
    for text in ("one:a", "force [N]", "a book", "+0.40 %", "<= 0.2", "pass", "1 cases, 0 failed"):
        assert text in result.output


@pytest.mark.parametrize("name", ["one", "one:b", "two"])
def test_a_failed_check_exits_with_status_4(name: str) -> None:
    result = CliRunner().invoke(verify, ["--only", name])
    assert result.exit_code == 4
    assert "FAIL" in result.output


def test_an_unknown_case_is_refused() -> None:
    result = CliRunner().invoke(verify, ["--only", "three"])
    assert result.exit_code == 3
    assert "no such case; found three; expected one, two" in result.output


def test_quiet_says_nothing() -> None:
    assert CliRunner().invoke(verify, ["--quiet", "--only", "one:a"]).output == ""


def test_json_and_csv_hold_the_same(tmp_path: Path) -> None:
    result = CliRunner().invoke(verify, ["--log-format", "json", "-o", str(tmp_path / "table.csv")])
    assert result.exit_code == 4
    lines = [json.loads(line) for line in result.output.splitlines()]
    with (tmp_path / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == [line["verdict"] for line in lines] == ["pass", "pass", "FAIL", "FAIL"]
    assert [row["case"] for row in rows] == ["one:a", "one:a", "one:b", "two"]
    assert float(rows[0]["found"]) == lines[0]["found"] == 1.004
    assert "no balance" in rows[3]["quantity"]


@pytest.mark.parametrize(("kind", "code"), [(Interrupted, 130), (Stopped, 75)])
def test_an_interrupted_run_of_cases_keeps_the_results_so_far(
    kind: type[KnotfemError], code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def stops() -> list[Quantity]:
        raise kind("go on with knotfem resume")

    cases = [Case("one", right, "right", "a book"), Case("two", stops, "", ""), Case("three", right, "", "")]
    monkeypatch.setattr(suite, "closed_forms", lambda: cases)
    result = CliRunner().invoke(verify, ["-o", str(tmp_path / "table.csv")])
    assert result.exit_code == code
    assert "two was stopped before its end" in result.output
    assert "1 cases, 0 failed" in result.output
    assert "resume" not in result.output
    with (tmp_path / "table.csv").open() as file:
        assert [row["case"] for row in csv.DictReader(file)] == ["one", "one"]


def test_sigterm_ends_the_suite_wherever_a_case_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def computes() -> list[Quantity]:
        os.kill(os.getpid(), signal.SIGTERM)
        return right()

    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(suite, "closed_forms", lambda: [Case("one", computes, "", ""), Case("two", right, "", "")])
    try:
        result = CliRunner().invoke(verify, [])
        assert signal.getsignal(signal.SIGTERM) is before
    finally:
        signal.signal(signal.SIGTERM, before)
    assert result.exit_code == 75
    assert "one was stopped before its end" in result.output


def test_a_table_that_cannot_be_written_is_said_before_a_case_runs(tmp_path: Path) -> None:
    result = CliRunner().invoke(verify, ["-o", str(tmp_path / "missing" / "table.csv")])
    assert result.exit_code == 3
    assert "one:a" not in result.output


def test_settings_are_fixed() -> None:
    assert CliRunner().invoke(verify, ["--set", "solver.linear=superlu"]).exit_code == 3


def test_hard_cases_have_a_table_of_their_own() -> None:
    result = CliRunner().invoke(verify, ["--hard", "--small"])
    assert result.exit_code == 0
    for text in ("smallest J", "0.7", "force [N]", "1 cases, 0 failed", "a small knot"):
        assert text in result.output
    result = CliRunner().invoke(verify, ["--hard"])
    assert result.exit_code == 4
    assert "FAIL" in result.output


def test_only_hard_cases_have_small_versions() -> None:
    result = CliRunner().invoke(verify, ["--small"])
    assert result.exit_code == 3
    assert "only hard cases have small versions" in result.output
