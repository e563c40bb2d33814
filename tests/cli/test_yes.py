"""More than an hour of computation is asked about."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import knotfem.api
from knotfem_cli import common
from knotfem_cli.main import knotfem_command


def call(*arguments: object, answer: str | None = None) -> Result:
    return CliRunner().invoke(knotfem_command, [str(argument) for argument in arguments], input=answer)


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Goals of the runs that began; every run is expected to take too long."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(common, "LONG", 1.0)
    goals: list[str] = []
    monkeypatch.setattr(knotfem.api, "drive", lambda run, goal, *args, **kwargs: goals.append(goal))
    return goals


@pytest.mark.parametrize("verb", [("pull", "overhand"), ("tie", "overhand"), ("hold", "bowline", "--tighten", "1 N")])
def test_long_run_needs_confirmation(verb: tuple[str, ...], begun: list[str]) -> None:
    refused = call(*verb)
    assert refused.exit_code == 3
    assert "h of computation are expected" in refused.output
    assert "--yes" in refused.output
    assert not begun
    assert not Path("runs").exists()
    call(*verb, "--yes")
    assert len(begun) == 1


def test_time_limit_replaces_confirmation(begun: list[str]) -> None:
    call("pull", "overhand", "--set", "solver.time_limit=0.5 s")
    assert begun == ["pull"]


def test_a_study_is_asked_about(begun: list[str]) -> None:
    refused = call("stability", "bowline")
    assert refused.exit_code == 3
    assert "--yes" in refused.output
    Path("study.toml").write_text('scene = "overhand"\n[[axes]]\nkey = "contact.friction"\nvalues = [0.1, 0.2]\n')
    refused = call("sweep", "study.toml")
    assert refused.exit_code == 3, refused.output
    assert "--yes" in refused.output


@pytest.mark.parametrize(("answer", "runs"), [("y\n", 1), ("n\n", 0)])
def test_in_a_terminal_there_is_a_question(
    answer: str, runs: int, begun: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(common, "asks", lambda: True)
    asked = call("tie", "overhand", answer=answer)
    assert "Begin it?" in asked.output
    assert len(begun) == runs
