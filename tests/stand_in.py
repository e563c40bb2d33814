"""An engine of studies whose runs come to what they are told, at once and in order; nothing is computed."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable

from knotfem.study.engine.engine import Ended, Job
from knotfem.study.engine.outcomes import Outcome

Act = Callable[[Job], Outcome]


class StandIn:
    """See `knotfem.study.engine.engine.Engine`.

    Args:
        act: what becomes of a run; may write its results.
        workers: how many there are.

    Attributes:
        order: names of the runs that were handed out.
        jobs: by name.
        most: runs at a time.
    """

    def __init__(self, act: Act, workers: int = 1) -> None:
        self.act, self.workers = act, workers
        self.order: list[str] = []
        self.jobs: dict[str, Job] = {}
        self.most = 0
        self._queue: deque[Job] = deque()

    def __enter__(self) -> StandIn:
        return self

    def __exit__(self, *error: object) -> None:
        assert not self._queue or error[0] is not None

    @property
    def running(self) -> int:
        return len(self._queue)

    @property
    def busy(self) -> bool:
        return bool(self._queue)

    @property
    def free(self) -> int:
        return self.workers - len(self._queue)

    def submit(self, job: Job, *, priority: float = 0.0) -> None:
        job.prepare()
        self.order.append(job.name)
        self.jobs[job.name] = job
        self._queue.append(job)
        self.most = max(self.most, len(self._queue))

    def wait(self) -> Ended | None:
        job = self._queue.popleft()
        outcome = self.act(job)
        status = {"state": outcome.state, "reason": outcome.reason, "exit_code": outcome.exit_code}
        (job.run.path / "status.json").write_text(json.dumps(status))
        return Ended(job, outcome, "stand-in", 0.1, 0.1)
