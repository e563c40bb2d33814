"""The engine of studies: throughput of short runs, and a study whose worker and client are killed.

    python benchmarks/study_engine.py throughput [RUNS] [WORKERS]
    python benchmarks/study_engine.py kill [RUNS]

`throughput` runs short pulls of a discrete rod one after the other in this process, then as a study, and compares
runs per second. `kill` starts a scheduler and two workers by dask's own commands, kills one worker amid its runs, then
the client, starts the client again, and compares the table with that of an undisturbed study, byte by byte.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import knotfem as kf
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive
from knotfem.study.progress import SilentStudy, Tally
from knotfem.study.sweep.axes import points_of
from knotfem.study.sweep.plan import scene_of
from knotfem.study.sweep.study_file import read_study, study_text


def study(runs: int) -> dict[str, Any]:
    """A study of short runs: an overhand knot that is tied and pulled by 3 mm."""
    return {
        "name": "short",
        "scene": "overhand",
        "axes": [{"key": "contact.friction", "linspace": [0.1, 0.4, runs]}],
        "set": {
            "model": "rod",
            "rods.0.mesh.element_length": "6 mm",
            "contact.sample_spacing_over_diameter": 0.25,
            "tie.path": "direct",
            "steps.pull.displacement": "3 mm",
            "output.fields": False,
            "output.checkpoint_every": "0.1 s",
        },
        "collect": {
            "final_force": "final_force_N",
            "force_at_2": {"table": "force", "column": "force_N", "at": "2 mm"},
            "iterations": "newton_iterations",
        },
    }


class Ends(SilentStudy):
    """Notes when points end."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def update(self, tally: Tally) -> None:
        """Note a point that has ended."""
        while len(self.times) < tally.done:
            self.times.append(time.perf_counter())


def throughput(folder: Path, runs: int, workers: int) -> None:
    """Runs per second of one process without the engine, and of the engine."""
    wanted = read_study(study(runs))
    points = points_of(wanted)[: max(runs // 10, 5)]
    took, cpu = [], []
    for point in points:
        began, used = time.perf_counter(), time.process_time()
        run = RunDirectory.create(scene_of(wanted, point.values), folder / "alone" / point.name)
        drive(run, "pull")
        took.append(time.perf_counter() - began)
        cpu.append(time.process_time() - used)
    alone, alone_cpu = sum(took[1:]) / len(took[1:]), sum(cpu[1:]) / len(cpu[1:])
    ends = Ends()
    began, used = time.perf_counter(), time.process_time()
    kf.sweep(study(runs), out=folder / "study", jobs=workers, progress=ends)
    whole, client = time.perf_counter() - began, (time.process_time() - used) / runs
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    settled = ends.times[workers:]
    rate = (len(settled) - 1) / (settled[-1] - settled[0])
    spent = (children.ru_utime + children.ru_stime) / runs
    print(f"one process, no engine: {alone:.3f} s a run ({alone_cpu:.3f} s of CPU time), the first {took[0]:.2f} s")
    print(f"study of {runs} runs, {workers} workers: {whole:.1f} s in all, {workers / rate:.3f} s a run and worker")
    print(f"overhead a run: {workers / rate - alone:.3f} s")
    print(f"throughput over {workers} times that of one process: {rate * alone / workers:.3f}")
    print(f"the same with start and end of the cluster: {runs / whole * alone / workers:.3f}")
    print(f"CPU time a run: {spent:.3f} s in the workers, start included; {client:.3f} s in the client")


def kill(folder: Path, runs: int) -> None:
    """Kill a worker, then the client; compare tables."""
    undisturbed = kf.sweep(study(runs), out=folder / "undisturbed", progress=False)
    address = "tcp://127.0.0.1:18786"
    dask = [sys.executable, "-P", "-m"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    processes: list[subprocess.Popen[bytes]] = []

    def start(*arguments: str) -> subprocess.Popen[bytes]:
        processes.append(subprocess.Popen([*dask, *arguments], cwd=folder, **quiet))  # pyright: ignore[reportCallIssue, reportArgumentType]
        return processes[-1]

    try:
        start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "18786", "--no-dashboard")
        time.sleep(3.0)
        worker = ("distributed.cli.dask_worker", address, "--nthreads", "1", "--nworkers", "1", "--no-dashboard")
        first = start(*worker, "--no-nanny")
        start(*worker)
        (folder / "short.toml").write_text(study_text(read_study(study(runs))))
        out = folder / "disturbed"

        def client() -> subprocess.Popen[bytes]:
            return start("knotfem_cli", "sweep", "short.toml", "-o", str(out), "--scheduler", address)

        def done() -> int:
            files = out.glob("runs/*/status.json")
            return sum('"done"' in path.read_text() for path in files)

        one = client()
        wait_for(lambda: done() >= runs // 4)
        os.kill(first.pid, signal.SIGKILL)
        print(f"one of two workers killed with {done()} of {runs} points done")
        wait_for(lambda: done() >= runs // 2)
        os.kill(one.pid, signal.SIGKILL)
        one.wait()
        print(f"client killed with {done()} of {runs} points done")
        start(*worker)
        again = client()
        print(f"client started again ended with {again.wait()}, {done()} of {runs} points done")
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait()
    same = (out / "study.csv").read_bytes() == (undisturbed.path / "study.csv").read_bytes()
    print(f"tables are {'the same, byte by byte' if same else 'DIFFERENT'}: {undisturbed!r}")
    sys.exit(0 if same else 1)


def wait_for(condition: Any) -> None:
    """Wait until a condition holds, at most ten minutes."""
    deadline = time.monotonic() + 600.0
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)


if __name__ == "__main__":
    command, *numbers = sys.argv[1:]
    with tempfile.TemporaryDirectory() as place:
        if command == "throughput":
            throughput(Path(place), int(numbers[0]) if numbers else 200, int(numbers[1]) if len(numbers) > 1 else 2)
        else:
            kill(Path(place), int(numbers[0]) if numbers else 20)
