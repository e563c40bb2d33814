"""The verb `sweep`: brings all points of a study to an outcome and keeps their table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.scene.load import Overrides
from knotfem.study.engine.places import Place, place_of
from knotfem.study.progress import StudyProgress, showing
from knotfem.study.sweep.plan import Planned, cost_of, plan
from knotfem.study.sweep.points import Asked, Points, folder_at
from knotfem.study.sweep.study_file import Study, read_study, study_text
from knotfem.study.sweep.table import StudyTable


def sweep(
    study: str | Path | Mapping[str, Any],
    overrides: Overrides = (),
    *,
    rope: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    cluster: str | Path | None = None,
    progress: StudyProgress | bool = True,
) -> StudyTable:
    """Run a scene at every combination of axes, and collect what came of it.

    Points that have a result in the folder keep it, interrupted ones go on from their checkpoints, so that the same
    call goes on with a study that was stopped or killed. A point that fails is a result, with its reason. By default
    there are as many processes as processors, each with one run at a time; a script must call this under
    `if __name__ == "__main__":`, since these processes import it.

    Args:
        study: a TOML file, the folder of a study, or the tables of such a file.
        overrides: changes of scene keys for all points.
        rope: another rope, for which the scenes of all points are scaled before keys are changed; see `load_scene`.
        out: folder of the results; studies/NAME by default.
        jobs: runs at a time on this machine.
        scheduler: address of a dask scheduler that runs already, such as "tcp://host:8786".
        cluster: TOML file that says what to ask a cluster's batch system for.
        progress: whether to show progress, or an object that is told.

    Returns:
        The table, which is in study.csv too.

    Raises:
        InputError: the study is wrong; all problems at once.
        NotConverged: no point could be computed.
        Stopped: by SIGTERM; all runs have written checkpoints.
        Interrupted: by Ctrl-C, likewise.
        KnotfemError: the scheduler is gone, or runs crashed.
    """
    place = place_of(jobs, scheduler, cluster)
    wanted = planned_study(study, overrides, rope=rope, out=out)
    with showing(progress) as shown:
        return wanted.run(place, shown)


@dataclass(frozen=True, eq=False)
class PlannedStudy:
    """A study whose scenes are read.

    Attributes:
        study: what is asked for.
        folder: of the results.
        points: all of them.
    """

    study: Study
    folder: Path
    points: list[Planned]

    @property
    def ropes(self) -> list[str]:
        """How the scenes of its points were made for another rope, each once."""
        scenes = [entry.scene for entry in self.points if entry.scene is not None]
        return list(dict.fromkeys(str(scene.rope) for scene in scenes if scene.rope is not None))

    def cost(self, place: Place) -> dict[str, Any]:
        """What it would take; nothing is run."""
        return cost_of(self.points, self.folder, place)

    def run(self, place: Place, progress: StudyProgress) -> StudyTable:
        """Run it; see `sweep`."""
        asked = Asked(self.study.name, self.study.keys, self.study.collect, study_text(self.study))
        return Points(asked, self.folder, self.points, place, progress).run()


def planned_study(
    study: str | Path | Mapping[str, Any],
    overrides: Overrides = (),
    *,
    rope: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
) -> PlannedStudy:
    """Read a study and the scenes of its points; see `sweep` for the arguments.

    Raises:
        InputError: the study is wrong; all problems at once.
    """
    wanted = read_study(study, overrides, rope)
    folder = folder_of(study, wanted, out)
    return PlannedStudy(wanted, folder, plan(wanted, folder, None if isinstance(study, Mapping) else study))


def folder_of(study: str | Path | Mapping[str, Any], wanted: Study, out: str | Path | None) -> Path:
    """Where the results go.

    Raises:
        InputError: the place is a file.
    """
    if out is not None:
        folder = Path(out)
    elif not isinstance(study, Mapping) and Path(study).is_dir():
        folder = Path(study)
    else:
        folder = Path("studies") / wanted.name
    return folder_at(folder)
