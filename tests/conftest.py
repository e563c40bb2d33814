"""For all tests: the shared modules of this folder, and one thread a process."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    """Threads of small loops on busy cores mostly wait for each other; tests are run in parallel as a whole."""
    import numba

    numba.set_num_threads(1)
