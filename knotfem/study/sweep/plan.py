"""What a study will run: a scene for each point, and what is known of it already."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.errors import OVERRIDES, InputError, SeveralErrors
from knotfem.run.directory import RunDirectory
from knotfem.run.expected import Expected, expected
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene
from knotfem.shipped import scene_names
from knotfem.study.engine.outcomes import Outcome, known_outcome
from knotfem.study.engine.places import Place
from knotfem.study.sweep.axes import Point, points_of
from knotfem.study.sweep.study_file import Study
from knotfem.study.sweep.table import RUNS

STUDY_ERRORS = ("unknown key", "no such entry", "there is no table here", "no such file", "no shipped scene")
"""Problems that are of the study itself, not of a point."""
DEFAULTS = {"solver.threads": 1}
"""Set for all points unless the study says otherwise: results must not depend on where a run is computed."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A point, ready to run.

    Attributes:
        point: of the study.
        run: its directory, there or not.
        scene: None where its values make no valid scene.
        outcome: where there is one already.
        seconds: expected wall time, right within a factor of three, unless the knot unravels.
        if_it_unravels: the same if it does.
        memory_mb: expected.
    """

    point: Point
    run: RunDirectory
    scene: Scene | None
    outcome: Outcome | None
    seconds: float = 0.0
    if_it_unravels: float = 0.0
    memory_mb: float = 0.0


def planned(point: Point, run: RunDirectory, scene: Scene, takes: Expected | None = None) -> Planned:
    """A point whose values make a valid scene.

    Args:
        point: of the study.
        run: its directory, there or not.
        scene: of the point.
        takes: what it is expected to take; None to find out.

    Raises:
        InputError: the directory holds a run of another scene.
    """
    takes = expected(scene) if takes is None else takes
    outcome = known_outcome(run, scene)
    return Planned(point, run, scene, outcome, takes.seconds, takes.if_it_unravels, takes.memory_mb)


def plan(study: Study, folder: Path, file: str | Path | None = None) -> list[Planned]:
    """All points of a study, with what its folder knows of them.

    Args:
        study: what is asked for.
        folder: of its results.
        file: that it was read from, for messages.

    Raises:
        InputError: keys that no scene has, or no point that is a valid scene; all problems at once. Or two points are
            the same scene, or the folder holds runs of other scenes.
    """
    entries = [_planned(study, point, folder) for point in points_of(study)]
    refused = [entry for entry in entries if isinstance(entry, tuple)]
    fatal = [error for _, error in refused if error.problem.startswith(STUDY_ERRORS)]
    if fatal or len(refused) == len(entries):
        found = fatal or [error for _, error in refused]
        raise SeveralErrors(list({str(error): error for error in (_placed(error, file) for error in found)}.values()))
    _check_different([entry for entry in entries if isinstance(entry, Planned)], file)
    return [entry if isinstance(entry, Planned) else _refused(*entry, folder) for entry in entries]


def _check_different(points: Sequence[Planned], file: str | Path | None) -> None:
    """Refuse points that are one and the same scene, which would be counted twice.

    Raises:
        InputError: there are some.
    """
    seen: dict[str, Point] = {}
    for entry in points:
        assert entry.scene is not None, "has none only where it is refused"
        first = seen.setdefault(entry.scene.model_dump_json(), entry.point)
        if first is not entry.point:
            found = " and ".join(_values_of(point) for point in (first, entry.point))
            raise InputError("two points are the same scene", file=file, key="axes", found=found, expected="each once")


def _values_of(point: Point) -> str:
    return ", ".join(f"{key} = {value}" for key, value in point.values.items())


def _placed(error: InputError, file: str | Path | None) -> InputError:
    """The error of a scene's key, at the file of the study."""
    if error.file != OVERRIDES:
        return error
    return InputError(error.problem, file=file, key=error.key, found=error.found, expected=error.expected)


def scene_of(study: Study, values: Mapping[str, Any]) -> Scene:
    """The scene of a point.

    Raises:
        InputError: the values make no valid scene.
    """
    wanted = {**DEFAULTS, **study.set, **values}
    source = str(wanted.pop("scene", study.scene))
    if source not in scene_names() and (study.base / source).exists():
        source = str(study.base / source)
    changes = {key: None if value == "none" else value for key, value in wanted.items()}
    rope = None if study.rope is None else study.rope.model_dump(mode="json", exclude_none=True)
    return load_scene(source, changes, study.base, rope=rope)


def _planned(study: Study, point: Point, folder: Path) -> Planned | tuple[Point, InputError]:
    try:
        scene = scene_of(study, point.values)
        takes = expected(scene)  # which reads its curves
    except InputError as error:
        return point, error
    return planned(point, RunDirectory(folder / RUNS / point.name), scene, takes)


def _refused(point: Point, error: InputError, folder: Path) -> Planned:
    outcome = Outcome("failed", str(_placed(error, None)), error.exit_code)
    return Planned(point, RunDirectory(folder / RUNS / point.name), None, outcome)


def cost_of(points: Sequence[Planned], folder: Path, place: Place) -> dict[str, Any]:
    """What points would take that have no outcome yet.

    Args:
        points: all of them.
        folder: of the study.
        place: where they are computed.
    """
    left = [entry for entry in points if entry.outcome is None]
    refused = {entry.point.name: entry.outcome.reason for entry in points if entry.outcome and entry.scene is None}
    largest = sorted((entry.memory_mb for entry in left), reverse=True)[: place.slots]
    found = {
        "folder": str(folder),
        "points": len(points),
        "runs": len(left),
        "known already": len(points) - len(left) - len(refused),
        "no valid scene": refused,
        "runs at a time": place.slots,
        **_hours([entry.seconds for entry in left], place.slots, ""),
        **(
            _hours([entry.if_it_unravels for entry in left], place.slots, "_if_all_unravel")
            if any(entry.if_it_unravels > entry.seconds for entry in left)
            else {}
        ),
        "expected_memory_mb": round(sum(largest)),
        "expected_memory_mb_of_a_run": round(max(largest, default=0.0)),
    }
    script = place.job_script()
    return found if script is None else {**found, "job_script": script}


def _hours(seconds: Sequence[float], slots: int, when: str) -> dict[str, float]:
    """Expected hours of runs, of which so many are computed at a time, and of CPU time."""
    total, longest = sum(seconds) / 3600.0, max(seconds, default=0.0) / 3600.0
    return {
        f"expected_hours{when}": _short(max(total / slots, longest)), f"expected_cpu_hours{when}": _short(total)
    }  # fmt: skip


def longest_hours(cost: Mapping[str, Any]) -> float:
    """Hours that points would take at the most, as `cost_of` tells."""
    return float(cost.get("expected_hours_if_all_unravel", cost["expected_hours"]))


def _short(hours: float) -> float:
    return float(f"{hours:.2g}")
