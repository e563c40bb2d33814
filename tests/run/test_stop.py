"""Stopping in order: signals and the time limit only set a flag."""

import os
import signal
import threading
import time
from collections.abc import Iterator

import pytest

from knotfem.errors import Interrupted, Stopped
from knotfem.run.stop import StopRequest


@pytest.fixture(autouse=True)
def terminal_that_may_close() -> Iterator[None]:
    """SIGHUP as it is in a terminal, whoever started these tests."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    ("number", "kind"), [(signal.SIGTERM, Stopped), (signal.SIGHUP, Stopped), (signal.SIGINT, Interrupted)]
)
def test_a_signal_sets_the_flag(number: signal.Signals, kind: type[Exception]) -> None:
    before = signal.getsignal(number)
    with StopRequest() as stop:
        assert not stop.due
        os.kill(os.getpid(), number)
        assert stop.due
        assert isinstance(stop.error(), kind)
    assert signal.getsignal(number) is before


def test_a_closed_terminal_is_ignored_after_nohup() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with StopRequest() as stop:
        os.kill(os.getpid(), signal.SIGHUP)
        assert not stop.due


def test_exit_codes() -> None:
    with StopRequest() as stop:
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop.error().exit_code == 75
    with StopRequest() as stop:
        os.kill(os.getpid(), signal.SIGINT)
        assert stop.error().exit_code == 130


def test_a_second_ctrl_c_interrupts() -> None:
    with StopRequest():
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_time_limit() -> None:
    with StopRequest(time_limit=0.05) as stop:
        assert not stop.due
        time.sleep(0.06)
        assert stop.due
        assert stop.error().exit_code == 75
        assert "time limit" in str(stop.error())


def test_elsewhere_than_in_the_main_thread() -> None:
    seen: list[bool] = []

    def work() -> None:
        with StopRequest(time_limit=0.0) as stop:
            seen.append(stop.due)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [True]
