"""Process of one run: brings it to its end or, asked to stop or out of time, to a checkpoint.

`python -m knotfem.study.worker RUN [SECONDS]`
"""

from __future__ import annotations

import sys

from knotfem.errors import KnotfemError


def work(folder: str, seconds: str | None = None) -> int:
    """Go on with a run; returns its exit code.

    Args:
        folder: of the run.
        seconds: wall time after which it stops with a checkpoint.
    """
    from knotfem.api import resume

    try:
        resume(folder, [] if seconds is None else [f"solver.time_limit={seconds} s"], progress=False)
    except KnotfemError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(work(*sys.argv[1:]))
