"""What people import: verbs that run scenes in memory or on disk, and open what was run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from knotfem.errors import InputError
from knotfem.models.base import Additions, Obstacle, TermMaker
from knotfem.plot.auto import RunFigures
from knotfem.results.compare import Comparison
from knotfem.results.compare import compare as compare_runs
from knotfem.results.data import DiskData, MemoryData
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive, goal_of
from knotfem.run.memory import MemoryStore
from knotfem.run.progress import Progress, automatic_progress
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import LOG, PhaseDone, Simulation, TimeStepDone
from knotfem.run.source import source_rods
from knotfem.run.step_report import report_of
from knotfem.scene.load import load_scene
from knotfem.scene.model import Scene

Source = Scene | Run | str | Path
"""A scene, a run whose tied knot is taken up, or the file, folder or shipped name of one."""


def tie(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    *,
    out: str | Path | None = None,
    force: bool = False,
    progress: Progress | bool = True,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Run:
    """Map the centreline into the knot and let the loose knot come to rest.

    Args:
        source: a scene, or the file or shipped name of one.
        overrides: changes of scene keys, such as {"contact.friction": 0.37}.
        out: folder for a run directory; None runs in memory.
        force: replace a run that is in the folder.
        progress: whether to show progress: a bar in a terminal or notebook, else a line of the log "knotfem" for each
            step; or an object that is told.
        terms: forces of your own, or functions that make them from the model.
        obstacles: rigid bodies of your own.
        materials: laws of your own for the bulk of hexahedra, by the rod's name.

    Raises:
        KnotfemError: a scene that is wrong, or what ended the run.
    """
    additions = Additions(terms, obstacles, dict(materials or {}))
    return _run(source, overrides, "tie", out, force, progress, additions)


def pull(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    *,
    out: str | Path | None = None,
    force: bool = False,
    progress: Progress | bool = True,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Run:
    """Take all steps of a scene, tying first what is not tied yet; see `tie` for the arguments.

    Of a run the tied knot is taken up, with other steps, friction or effects where `overrides` say so.
    """
    additions = Additions(terms, obstacles, dict(materials or {}))
    return _run(source, overrides, "pull", out, force, progress, additions)


def resume(
    path: str | Path,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    *,
    progress: Progress | bool = True,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Run:
    """Go on from the last checkpoint of a run directory to what the run was asked for, to the same bits.

    Args:
        path: the run directory.
        overrides: changes of keys under solver and output.
        progress: see `tie`.
        terms, obstacles, materials: those that the run was begun with.
    """
    directory = RunDirectory.open(path)
    if overrides:
        directory.override(overrides)
    additions = Additions(terms, obstacles, dict(materials or {}))
    with closing(_progress(progress)) as shown, directory.locked():
        drive(directory.scene, directory, goal_of(directory), shown, additions=additions, figures=RunFigures())
    return open_run(path)


def steps(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    *,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Iterator[TimeStepDone]:
    """Yield the accepted time steps of a scene as they come, in memory; see `tie` for the arguments."""
    additions = Additions(terms, obstacles, dict(materials or {}))
    simulation = _simulation(source, overrides, "pull", additions, None)
    for event in simulation.run():
        if isinstance(event, TimeStepDone):
            yield event


def open_run(path: str | Path) -> Run:
    """The results in a run directory.

    Raises:
        InputError: no run is there.
    """
    directory = RunDirectory.open(path)
    return Run(DiskData(directory), directory.path.resolve().name)


def compare(
    *runs: Run | str | Path, locking: float | None = None, at: float | None = None, step: str | None = None
) -> Comparison:
    """Hold runs against the first of them; see `knotfem.results.compare.compare`."""
    opened = [run if isinstance(run, Run) else open_run(run) for run in runs]
    return compare_runs(opened, locking=locking, at=at, step=step)


def _run(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str],
    goal: str,
    out: str | Path | None,
    force: bool,
    progress: Progress | bool,
    additions: Additions,
) -> Run:
    with closing(_progress(progress)) as shown:
        if out is None:
            return _in_memory(source, overrides, goal, shown, additions)
        directory = _directory(source, overrides, Path(out), force)
        with directory.locked():
            drive(directory.scene, directory, goal, shown, additions=additions, figures=RunFigures())
    return open_run(directory.path)


def _in_memory(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str],
    goal: str,
    progress: Progress,
    additions: Additions,
) -> Run:
    simulation = _simulation(source, overrides, goal, additions, progress.message)
    store = MemoryStore()
    recorder = Recorder(simulation, store)
    recorder.begin(None)
    checkpoints: dict[str, dict[str, Any]] = {}
    for event in simulation.run():
        recorder.record(event)
        if isinstance(event, PhaseDone):
            if event.tied:
                checkpoints["tied"] = simulation.checkpoint()
        else:
            progress.step(report_of(event))
    checkpoints[""] = simulation.checkpoint()
    data = MemoryData(simulation.scene, store, recorder.finish(), checkpoints)
    return Run(data, simulation.scene.name)


def _simulation(
    source: Source,
    overrides: Mapping[str, Any] | Sequence[str],
    goal: str,
    additions: Additions,
    notify: Callable[[str], None] | None,
) -> Simulation:
    run = _as_run(source)
    scene = _scene_of(source if run is None else run.scene, overrides)
    rods = source_rods(scene) if scene.tie.source is not None else None
    simulation = Simulation(scene, goal, additions=additions, source=rods, notify=notify or LOG.info)
    if run is not None:
        tied = run.data.checkpoint("tied")
        if tied is None:
            raise InputError("not tied yet", file=run.path, expected="a run that tie or pull has brought that far")
        RunDirectory.check_branch(run.scene, scene, run.path)
        simulation.restore(tied)
    return simulation


def _directory(source: Source, overrides: Mapping[str, Any] | Sequence[str], out: Path, force: bool) -> RunDirectory:
    run = _as_run(source)
    if run is None:
        return RunDirectory.create(_scene_of(source, overrides), out, force=force)
    if run.path is None:
        raise InputError("a run in memory has no directory to go on from", expected="one that was made with out=")
    return RunDirectory.open(run.path).branch(_scene_of(run.scene, overrides), out, force=force)


def _as_run(source: Source) -> Run | None:
    if isinstance(source, Run):
        return source
    if isinstance(source, str | Path) and RunDirectory.is_run(source):
        return open_run(source)
    return None


def _scene_of(source: Source, overrides: Mapping[str, Any] | Sequence[str]) -> Scene:
    assert not isinstance(source, Run)
    if isinstance(source, Scene) and not overrides:
        return source
    return load_scene(source, overrides)


def _progress(progress: Progress | bool) -> Progress:
    return automatic_progress(shown=progress) if isinstance(progress, bool) else progress
