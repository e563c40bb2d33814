"""Where runs are computed: what a cluster is asked for, what is refused; nothing is started."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from knotfem.errors import InputError, MissingDependency, SeveralErrors
from knotfem.study.engine import places
from knotfem.study.engine.cluster_file import ClusterFile
from knotfem.study.engine.places import Jobqueue, Local, Scheduler, place_of, whole_machine

FILE = """
system = "{}"
jobs = 3
workers = 4
memory = "8 GB"
walltime = "1.5 h"
queue = "short"
account = "knots"
directives = ["-x 1"]
prologue = ["module load python"]
python = "/opt/python"
"""
HEADERS = {
    "slurm": [
        "#SBATCH -p short",
        "#SBATCH -A knots",
        "#SBATCH --cpus-per-task=4",
        "#SBATCH -t 01:30:00",
        "#SBATCH -x 1",
    ],
    "pbs": ["#PBS -q short", "#PBS -A knots", "#PBS -l select=1:ncpus=4:mem=7630MB", "#PBS -l walltime=01:30:00"],
    "sge": ["#$ -q short", "#$ -P knots", "#$ -l h_rt=01:30:00", "#$ -x 1"],
    "lsf": ["#BSUB -q short", '#BSUB -P "knots"', "#BSUB -n 4", "#BSUB -W 1:30", "#BSUB -x 1"],
}


def written(folder: Path, text: str) -> Path:
    path = folder / "cluster.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("system", list(HEADERS))
def test_job_script(system: str, tmp_path: Path) -> None:
    pytest.importorskip("dask_jobqueue")
    place = place_of(cluster=written(tmp_path, FILE.format(system)))
    assert isinstance(place, Jobqueue)
    assert place.slots == 12
    assert place.capacity(0) == 0
    adaptive = place_of(cluster=written(tmp_path, f"least_jobs = 0\n{FILE.format(system)}"))
    assert adaptive.capacity(0) == 12, "jobs are asked for as there is work"
    lines = place.job_script().splitlines()
    for header in HEADERS[system]:
        assert header in lines
    assert lines.index("module load python") < lines.index("export NUMBA_NUM_THREADS=1")
    assert lines[-1].startswith("/opt/python -m distributed.cli.dask_worker tcp://")
    assert " --nthreads 1 " in lines[-1]
    assert " --nworkers 4 " in lines[-1]


def test_missing_library_is_named_with_its_cure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dask_jobqueue", None)
    place = place_of(cluster=written(tmp_path, FILE.format("slurm")))
    with pytest.raises(MissingDependency, match=r"pip install 'knotfem\[cluster\]'"):
        place.job_script()


def test_all_that_is_wrong_with_a_file(tmp_path: Path) -> None:
    path = written(tmp_path, 'system = "slrm"\njobs = 0\nleast_jobs = 2\nmemory = "8"\nwalltime = 3\n')
    with pytest.raises(SeveralErrors) as caught:
        ClusterFile.read(path)
    lines = str(caught.value).splitlines()
    assert [line.partition(": ")[2].partition(":")[0] for line in lines] == ["system", "jobs", "memory", "walltime"]
    assert f'{path}: system: unknown choice; found "slrm"; expected "slurm", or one of pbs, sge, lsf' in lines
    with pytest.raises(InputError, match="at most jobs = 1"):
        ClusterFile.read(written(tmp_path, 'system = "sge"\njobs = 1\nleast_jobs = 2\nmemory = "8 GB"\n'))


def test_one_place_at_most() -> None:
    assert place_of() == Local()
    assert (Local(3).capacity(2), Scheduler("tcp://a:1").capacity(2)) == (3, 2)
    assert place_of(scheduler="tcp://a:1") == Scheduler("tcp://a:1")
    with pytest.raises(InputError, match="more than one place"):
        place_of(jobs=2, scheduler="tcp://a:1")


def test_fewer_processes_have_more_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "usable_threads", lambda: 8)
    assert whole_machine(Local(2)) == Local(2, 4)
    assert whole_machine(Local()) == Local(None, 1)
    assert whole_machine(Local(16)) == Local(16, 1)


def test_environment_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with places._environment(3):
        assert os.environ["OMP_NUM_THREADS"] == os.environ["MKL_NUM_THREADS"] == "3"
        os.environ["LEFT_BY_DASK"] = "1"
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert not {"MKL_NUM_THREADS", "LEFT_BY_DASK"} & set(os.environ)


def test_jobs_that_have_ended_are_asked_for_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    class Cluster:
        """A cluster that is asked for jobs."""

        scheduler_address = "inproc://"

        def scale(self, jobs: int) -> None:
            asked.append(jobs)

        def close(self) -> None:
            asked.append(0)

    place = place_of(cluster=written(tmp_path, FILE.format("slurm")))
    assert isinstance(place, Jobqueue)
    monkeypatch.setattr(ClusterFile, "make", lambda self: Cluster())
    monkeypatch.setattr("distributed.Client", lambda *cluster, **options: Cluster())
    place.renew()
    with place.client():
        place.renew()
        assert asked == [3], "not so soon"
        monkeypatch.setattr(places, "RENEW_EVERY", -1.0)
        place.renew()
        assert asked == [3, 3]
    place.renew()
    assert asked == [3, 3, 0, 0], "not after the end"
