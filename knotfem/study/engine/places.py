"""Where the workers are: on this machine, behind a scheduler that runs already, or jobs of a cluster."""

from __future__ import annotations

import logging
import multiprocessing
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from knotfem.errors import InputError, KnotfemError
from knotfem.study.engine.cluster_file import ClusterFile
from knotfem.threads import VARIABLES, usable_threads

if TYPE_CHECKING:
    from distributed import Client

CONNECT_TIMEOUT = 20.0
"""Seconds until a scheduler must have answered."""
RENEW_EVERY = 20.0
"""Seconds between requests for the jobs of a cluster; those that are there are not asked for again."""
NUMBA = "NUMBA_NUM_THREADS"
_GUARD = (
    "a script that runs a study starts processes that import the script again; "
    'cure: put what it does under `if __name__ == "__main__":`'
)


class Place(ABC):
    """Where the workers of a study are."""

    local = False
    """Whether they are on this machine, so that its memory and disk are theirs."""
    threads = 1
    """Of each run."""

    @abstractmethod
    def client(self) -> AbstractContextManager[Client]:
        """A context with a client of the scheduler; what it started ends with it.

        Raises:
            KnotfemError: there is no scheduler, or it did not start.
        """

    @property
    @abstractmethod
    def slots(self) -> int:
        """Runs at a time that are expected, for estimates."""

    def capacity(self, workers: int) -> int:
        """Runs to hand out at a time.

        Args:
            workers: that the scheduler has now.
        """
        return workers

    def renew(self) -> None:
        """Replace workers that have gone, where that does not happen by itself; called every few seconds."""
        return

    def job_script(self) -> str | None:
        """The script of a cluster's jobs, or None."""
        return None


@dataclass
class Local(Place):
    """Processes of this machine, one run at a time each.

    Attributes:
        jobs: processes; None for one a processor.
        threads: of each.
    """

    jobs: int | None = None
    threads: int = 1
    local = True

    @property
    def slots(self) -> int:
        """One a processor unless told otherwise."""
        return self.jobs or usable_threads()

    def capacity(self, workers: int) -> int:
        """A process that has died is started again."""
        return self.slots

    @contextmanager
    def client(self) -> Iterator[Client]:
        """See `Place.client`."""
        if getattr(multiprocessing.current_process(), "_inheriting", False):
            raise KnotfemError(_GUARD)
        from distributed import Client, LocalCluster

        with ExitStack() as stack:
            stack.enter_context(_environment(self.threads))
            try:
                cluster = LocalCluster(
                    n_workers=self.slots,
                    threads_per_worker=1,
                    processes=True,
                    memory_limit=0,
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,
                    env={NUMBA: str(self.threads)},
                )
            except Exception as error:
                message = f"the processes of the study did not start ({error}); if this is a script: {_GUARD}"
                raise KnotfemError(message) from None
            stack.callback(_quietly, cluster.close)
            client = Client(cluster)
            stack.callback(_quietly, client.close)
            yield client


@dataclass
class Scheduler(Place):
    """A scheduler that runs already.

    Attributes:
        address: such as tcp://host:8786.
    """

    address: str
    _seen: int = field(default=1, init=False)

    @property
    def slots(self) -> int:
        """Workers that were there when the client connected."""
        return self._seen

    @contextmanager
    def client(self) -> Iterator[Client]:
        """See `Place.client`."""
        from distributed import Client

        with _silent():
            try:
                client = Client(self.address, timeout=CONNECT_TIMEOUT, set_as_default=False)
            except (OSError, ValueError, TypeError) as error:
                expected = "the address that `dask scheduler` prints, such as tcp://host:8786"
                raise InputError(
                    f"no scheduler answers ({error})", key="--scheduler", found=self.address, expected=expected
                ) from None
            try:
                self._seen = max(workers_of(client), 1)
                yield client
            finally:
                _quietly(client.close)


@dataclass
class Jobqueue(Place):
    """Jobs of a cluster's batch system, by dask-jobqueue.

    Attributes:
        file: what to ask for.
    """

    file: ClusterFile
    _cluster: Any = field(default=None, init=False)
    _asked: float = field(default=0.0, init=False)

    @property
    def slots(self) -> int:
        """Processes of all jobs."""
        return self.file.jobs * self.file.workers

    @contextmanager
    def client(self) -> Iterator[Client]:
        """See `Place.client`."""
        from distributed import Client

        with _silent():
            cluster = self._cluster = self.file.make()
            try:
                self._ask()
                client = Client(cluster, set_as_default=False)
                try:
                    yield client
                finally:
                    _quietly(client.close)
            finally:
                self._cluster = None
                _quietly(cluster.close)

    def capacity(self, workers: int) -> int:
        """Where jobs are asked for as there is work, there must be work for all of them first."""
        return workers if self.file.least_jobs is None else max(workers, self.slots)

    def renew(self) -> None:
        """Ask for jobs in the place of those that have ended, such as at their wall time."""
        if self._cluster is not None and time.monotonic() - self._asked > RENEW_EVERY:
            self._ask()

    def job_script(self) -> str:
        """As it would be submitted, but for the address of the scheduler."""
        with _silent():
            cluster = self.file.make()
            try:
                return str(cluster.job_script())
            finally:
                _quietly(cluster.close)

    def _ask(self) -> None:
        self.file.scale(self._cluster)
        self._asked = time.monotonic()


def place_of(
    jobs: int | None = None, scheduler: str | None = None, cluster: str | os.PathLike[str] | None = None
) -> Place:
    """Where the workers are, by what the user says; this machine by default.

    Args:
        jobs: runs at a time on this machine.
        scheduler: address of one that runs already.
        cluster: TOML file of a batch system; see `cluster_file.ClusterFile`.

    Raises:
        InputError: more than one is named, or the file is wrong.
    """
    named = {"--jobs": jobs, "--scheduler": scheduler, "--cluster": cluster}
    given = [name for name, value in named.items() if value is not None]
    if len(given) > 1:
        raise InputError("more than one place for the runs", key=", ".join(given), expected="one of them")
    if scheduler is not None:
        return Scheduler(scheduler)
    if cluster is not None:
        return Jobqueue(ClusterFile.read(cluster))
    return Local(jobs)


def whole_machine(place: Place) -> Place:
    """The same place; processes of this machine share all its processors, so that fewer have more threads each."""
    return Local(place.jobs, max(1, usable_threads() // place.slots)) if isinstance(place, Local) else place


def workers_of(client: Any) -> int:
    """How many workers a client's scheduler has; each takes one run at a time."""
    return len(client.nthreads())


def page_of(place: Place, client: Any) -> str:
    """Address of the dashboard, or "" where there is none."""
    here = find_spec("bokeh") is not None if place.local else "dashboard" in client.scheduler_info()["services"]
    return str(client.dashboard_link) if here else ""


@contextmanager
def _environment(threads: int) -> Iterator[None]:
    """Variables that processes must have before numerics are imported; Numba's, which this process heeds too, is not
    among them and is set in the processes."""
    before = dict(os.environ)
    os.environ.update({name: str(threads) for name in VARIABLES if name != NUMBA})
    try:
        yield
    finally:
        for name in set(os.environ) - set(before):
            del os.environ[name]
        os.environ.update(before)


@contextmanager
def _silent() -> Iterator[None]:
    """Keep dask's log from the terminal: what a user must know, the engine tells."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(before)


def _quietly(close: Any) -> None:
    """Close what may be gone already."""
    with suppress(Exception):
        close()
