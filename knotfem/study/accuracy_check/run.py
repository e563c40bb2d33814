"""The verb `check_accuracy`: pulls a scene with settings whose error was measured to be within a target."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

from knotfem.errors import InputError
from knotfem.run.directory import RunDirectory
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.scene.quantity import DURATION, parse_quantity
from knotfem.study.accuracy import parse_fraction, refuse_governed, starting_point
from knotfem.study.accuracy_check.deliver import check_place, deliver
from knotfem.study.accuracy_check.report import CheckedAccuracy, block_of
from knotfem.study.accuracy_check.search import Search
from knotfem.study.engine.places import Place, place_of, whole_machine
from knotfem.study.jobs import Jobs
from knotfem.study.progress import StudyProgress, showing
from knotfem.study.records import stored
from knotfem.study.refinement import Level


def check_accuracy(
    source: Scene | str | Path,
    accuracy: float | str,
    overrides: Overrides = (),
    *,
    out: str | Path | None = None,
    budget: float | str | None = None,
    force: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    cluster: str | Path | None = None,
    progress: StudyProgress | bool = True,
) -> CheckedAccuracy:
    """Pull a knot with settings whose error, measured on this very scene, is within a target.

    Sets out from the settings that `--accuracy` recommends, or the most accurate ones that were measured for scenes of
    this class, or the scene as it is. Runs the next finer setting of each choice, and takes finer ones until the sum of
    what they change, extrapolated by first order, is within the target. All errors are those of the scene's own model.

    The runs are kept in the folder OUT-check: the same call goes on where it was stopped, and runs nothing again. By
    default there are as many processes as processors; a script must call this under `if __name__ == "__main__":`.

    Args:
        source: a scene, or the file or shipped name of one.
        accuracy: largest relative error of the force curve (L2), such as "2%" or 0.02; where nothing is pulled, of the
            sag or the shape.
        overrides: changes of scene keys but those that the accuracy decides.
        out: run directory of the result; runs/SCENE-accurate by default.
        budget: time after which nothing more is begun, [s] or such as "1h".
        force: replace a run that is in the folder; the result of an earlier call is always replaced.
        jobs: runs at a time on this machine.
        scheduler: address of a dask scheduler that runs already.
        cluster: TOML file that says what to ask a cluster's batch system for.
        progress: whether to show progress, or an object that is told.

    Returns:
        The run and the measured error; `reached` says whether it is within the target.

    Raises:
        InputError: the scene, the accuracy or the folder is wrong.
        KnotfemError: the scene itself fails.
        Stopped: by SIGTERM; checkpoints are written.
        Interrupted: by Ctrl-C, likewise.
    """
    target = parse_fraction(accuracy if isinstance(accuracy, str) else repr(accuracy))
    seconds = parse_quantity(budget, DURATION, "--budget") if isinstance(budget, str) else budget
    if isinstance(source, str | Path) and RunDirectory.is_run(source):
        raise InputError("a run keeps its settings", file=source, key="--accuracy", expected="a scene")
    refuse_governed(overrides)
    asked = load_scene(source, overrides)
    place = place_of(jobs, scheduler, cluster)
    if asked.model == "fem":  # discrete rods gain nothing by several threads
        place = whole_machine(place)
    result = Path(out) if out is not None else Path("runs") / f"{asked.name}-accurate"
    folder = result.with_name(f"{result.name}-check")
    check_place(result, folder, force=force)
    settings, start = starting_point(asked, target, stored())
    base = load_scene(asked, [*settings, "accuracy=none"])
    with showing(progress) as shown:
        shown.message(f"starts from {start}")
        found = Search(_jobs(base, folder, seconds, place, shown.message), target, shown.message).run()
        block = block_of(found, target, folder, start)
        run = deliver(RunDirectory(folder / "runs" / found.level.name), result, block)
    return CheckedAccuracy(
        run, target, found.estimate, found.quantity, found.changes, found.ended, found.cpu_s, folder, start
    )


def _jobs(base: Scene, folder: Path, budget: float | None, place: Place, tell: Callable[[str], None]) -> Jobs:
    @cache
    def scene_of(level: Level) -> Scene:
        return load_scene(base, [f"solver.threads={place.threads}", *level.overrides])

    deadline = time.monotonic() + budget if budget is not None else float("inf")
    return Jobs(folder, scene_of, place, deadline, tell)
