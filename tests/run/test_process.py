"""A status that says "running" is believed only while its process is there."""

import subprocess
import sys

import pytest

from knotfem.run.process import has_gone, this_process


def test_this_process_is_there() -> None:
    assert not has_gone({"state": "running", **this_process()})
    assert not has_gone({"state": "done", "pid": 0})


def test_a_process_that_has_ended_has_gone() -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert has_gone({"state": "running", **this_process(), "pid": ended.pid})


def test_another_process_with_the_same_number_is_not_it() -> None:
    status = {"state": "running", **this_process()}
    assert has_gone({**status, "process_started": status["process_started"] - 1000.0})


def test_nobody_knows_of_other_machines() -> None:
    assert not has_gone({"state": "running", "pid": 999999999, "process_started": 1.0, "host": "elsewhere"})


@pytest.mark.parametrize("broken", [{"pid": "x"}, {"pid": None}, {"process_started": "late"}])
def test_a_status_that_names_no_process(broken: dict[str, object]) -> None:
    assert has_gone({"state": "running", **this_process(), **broken})
