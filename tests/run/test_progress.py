"""Progress on a terminal, in a file, as JSON, or none."""

import errno
import io
import json
import math
from dataclasses import replace

import pytest

from knotfem.run import progress
from knotfem.run.progress import JsonLines, Lines, LiveBar, Silent, StepReport, Unfailing, make_progress

REPORT = StepReport("pull", 0.25, 6.2, 24.75, 0.1234, 0.5, 140, 0.034, 5)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_the_kind_that_fits() -> None:
    assert isinstance(make_progress(quiet=True, stream=Terminal()), Silent)
    for kind, made in (
        (JsonLines, make_progress(log_format="json", stream=Terminal())),
        (Lines, make_progress(stream=io.StringIO())),
        (LiveBar, make_progress(stream=Terminal())),
    ):
        assert isinstance(made, Unfailing)
        assert isinstance(made.inner, kind)
        made.close()


@pytest.mark.parametrize("kind", [io.StringIO, Terminal])
@pytest.mark.parametrize("log_format", ["text", "json"])
def test_a_terminal_that_has_closed_does_not_end_a_run(kind: type[io.StringIO], log_format: str) -> None:
    class Closed(kind):
        def write(self, text: str) -> int:
            raise OSError(errno.EIO, "Input/output error")

    told = make_progress(log_format=log_format, stream=Closed())  # pyright: ignore[reportArgumentType]
    told.message("hello")
    told.step(REPORT)
    told.close()
    assert isinstance(told, Unfailing)
    assert isinstance(told.inner, Silent)


def test_a_line_for_each_output(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    stream = io.StringIO()
    lines = make_progress(stream=stream)
    lines.message("hello")
    lines.step(StepReport("pull", 0.0))
    clock[0] = 10.0
    lines.step(replace(REPORT, due=True))
    lines.close()
    hello, first, second = stream.getvalue().splitlines()
    assert hello == "hello"
    assert "left" not in first
    expected = "25.0 %  0:30 left  24.75 mm  0.1234 N  140 contacts  0.034 mm deep  5 iterations"
    assert second == f"pull      {expected}  step 0.5 mm  simulated 6.2 s"


def test_between_outputs_there_is_a_line_once_in_a_while_and_no_message_is_lost(clock: list[float]) -> None:
    stream = io.StringIO()
    lines = make_progress(stream=stream)
    for step in range(1000):
        clock[0] = 0.1 * step
        lines.step(StepReport("pull", 0.001 * step, due=step % 250 == 249))
        if step == 500:
            lines.message("jump at 30 mm")
    text = stream.getvalue()
    assert "jump at 30 mm" in text
    assert 1 + 4 + 1 <= len(text.splitlines()) <= 1 + 4 + 4 + 1
    lines.step(StepReport("relax"))
    assert stream.getvalue().splitlines()[-1].startswith("relax")


def test_time_left_starts_with_each_phase(clock: list[float]) -> None:
    stream = io.StringIO()
    lines = make_progress(stream=stream)
    for now, phase, fraction in [
        (0.0, "relax", 0.0),
        (100.0, "relax", 1.0),
        (100.0, "pull", 0.5),
        (103.0, "pull", 0.501),
    ]:
        clock[0] = now
        lines.step(StepReport(phase, fraction, due=True))
    assert "  24:57 left  " in stream.getvalue().splitlines()[-1]
    clock[0] = 107.0
    lines.step(StepReport("pull", 0.5005, due=True))
    assert "  1:56:33 left  " in stream.getvalue().splitlines()[-1]


def test_json_lines(clock: list[float]) -> None:
    stream = io.StringIO()
    lines = make_progress(log_format="json", stream=stream)
    lines.message("hello")
    lines.step(StepReport("pull", 0.0))
    clock[0] = 10.0
    lines.step(REPORT)
    lines.step(StepReport("release", math.nan))
    hello, first, second, third = map(json.loads, stream.getvalue().splitlines())
    assert hello == {"message": "hello"}
    assert first["time_left_s"] is None
    assert (second["phase"], second["force_N"], second["displacement_mm"], second["contacts"]) == (
        "pull",
        0.1234,
        24.75,
        140,
    )
    assert (second["max_penetration_mm"], second["newton_iterations"]) == (0.034, 5)
    assert second["time_left_s"] == pytest.approx(30.0)
    assert third["fraction"] is None


def test_a_live_bar_shows_the_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    bar = make_progress(stream=stream)
    bar.message("compiling [kernels]")
    bar.step(StepReport("relax", math.nan))
    bar.step(REPORT)
    bar.close()
    text = stream.getvalue()
    assert "compiling [kernels]" in text
    assert "0.1234 N" in text
    assert "140 contacts" in text
