"""The file that says what to ask a cluster's batch system for; dask-jobqueue asks."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from knotfem.errors import InputError, MissingDependency, SeveralErrors
from knotfem.scene.load import read_toml
from knotfem.scene.quantity import PositiveDuration
from knotfem.scene.table import Integer, Table, input_errors, refusal
from knotfem.threads import VARIABLES

_CLASSES = {"slurm": "SLURMCluster", "pbs": "PBSCluster", "sge": "SGECluster", "lsf": "LSFCluster"}
_ACCOUNT = {"slurm": "account", "pbs": "account", "sge": "project", "lsf": "project"}
"""What each system's accounting is called."""


class ClusterFile(Table):
    """What to ask for.

    Attributes:
        system: of the cluster.
        jobs: how many jobs to ask for.
        least_jobs: with it, jobs are asked for as there is work, from so many up to `jobs`; without, all at once.
        workers: single-threaded processes, and so runs at a time, of a job; it asks for as many cores.
        memory: of a job, such as "4 GB".
        walltime: of a job; runs that are under way when it ends go on from their checkpoints in another one.
        queue: or partition.
        account: or project, that the time is charged to.
        directives: further lines of the job's header, without "#SBATCH" and the like.
        prologue: commands before the workers start, such as "module load python".
        python: interpreter on the nodes; by default the path of this one.
        interface: network interface, such as "ib0".
        local_directory: for temporary files on the nodes.
        log_directory: for what the jobs print.
        options: further arguments of the class of dask-jobqueue, by name.
    """

    system: Literal["slurm", "pbs", "sge", "lsf"]
    jobs: Annotated[Integer, Field(ge=1)]
    least_jobs: Annotated[Integer, Field(ge=0)] | None = None
    workers: Annotated[Integer, Field(ge=1)] = 1
    memory: Annotated[str, Field(pattern=r"^\s*\d+(\.\d+)?\s*[kKMGT]i?B\s*$")]
    walltime: PositiveDuration | None = None
    queue: str | None = None
    account: str | None = None
    directives: tuple[str, ...] = ()
    prologue: tuple[str, ...] = ()
    python: str = sys.executable
    interface: str | None = None
    local_directory: str | None = None
    log_directory: str | None = None
    options: Annotated[dict[str, Any], Field(default_factory=dict)]

    @model_validator(mode="after")
    def _check_jobs(self) -> Self:
        if self.least_jobs is not None and self.least_jobs > self.jobs:
            found, expected = str(self.least_jobs), f"at most jobs = {self.jobs}"
            raise refusal("more than the most", at="least_jobs", found=found, expected=expected)
        return self

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> ClusterFile:
        """Read and validate a file.

        Raises:
            InputError: what is wrong with it, all at once.
        """
        tables = read_toml(Path(path))
        try:
            return cls.model_validate(tables)
        except ValidationError as error:
            raise SeveralErrors(input_errors(error, tables, file=path)) from None

    def arguments(self) -> dict[str, Any]:
        """Arguments of the class of dask-jobqueue."""
        threads = [f"export {name}=1" for name in VARIABLES]
        given = {
            "queue": self.queue,
            _ACCOUNT[self.system]: self.account,
            "walltime": None if self.walltime is None else self._walltime(self.walltime),
            "interface": self.interface,
            "local_directory": self.local_directory,
            "log_directory": self.log_directory,
        }
        return {
            "cores": self.workers,
            "processes": self.workers,
            "memory": self.memory.strip(),
            "job_name": "knotfem",
            "python": self.python,
            "job_script_prologue": [*self.prologue, *threads],
            "job_extra_directives": list(self.directives),
            **{name: value for name, value in given.items() if value is not None},
            **self.options,
        }

    def _walltime(self, seconds: float) -> str:
        """As the system writes it: H:MM for LSF, HH:MM:SS elsewhere; rounded up."""
        whole = max(int(-(-seconds // 1)), 1)
        if self.system == "lsf":
            minutes = -(-whole // 60)
            return f"{minutes // 60}:{minutes % 60:02d}"
        return f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}"

    def make(self) -> Any:
        """The cluster, whose scheduler runs in this process; nothing has been asked for yet.

        Raises:
            MissingDependency: dask-jobqueue is missing.
            InputError: it refuses what it is asked for.
        """
        try:
            import dask_jobqueue
        except ImportError:
            raise MissingDependency("dask-jobqueue is missing; cure: pip install 'knotfem[cluster]'") from None
        try:
            return getattr(dask_jobqueue, _CLASSES[self.system])(**self.arguments())
        except (TypeError, ValueError, OSError, RuntimeError) as error:
            raise InputError(f"the cluster cannot be asked ({error})", key="--cluster") from None

    def scale(self, cluster: Any) -> None:
        """Ask for the jobs that are not there; again for those that have ended."""
        if self.least_jobs is None:
            cluster.scale(jobs=self.jobs)
        elif getattr(cluster, "_adaptive", None) is None:
            cluster.adapt(minimum_jobs=self.least_jobs, maximum_jobs=self.jobs)
