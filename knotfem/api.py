"""What people import: verbs that run scenes in memory or on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from knotfem.errors import InputError, KnotfemError
from knotfem.models.base import Additions, Obstacle, TermMaker, no_term
from knotfem.models.series import Fields
from knotfem.results.data import MemoryRun, open_run
from knotfem.results.figures import RunFigures
from knotfem.results.run import Run
from knotfem.run.additions import names_of, require
from knotfem.run.checkpoint import RunCheckpoint
from knotfem.run.directory import RunDirectory
from knotfem.run.driver import drive, goal_of
from knotfem.run.events import PhaseDone, TimeStepDone
from knotfem.run.memory import MemoryStore, StoredState
from knotfem.run.progress import Progress, automatic_progress
from knotfem.run.recorder import Recorder
from knotfem.run.simulation import LOG, Simulation
from knotfem.run.source import source_rods
from knotfem.run.step_report import report_of
from knotfem.run.stop import StopRequest
from knotfem.scene.load import Overrides, load_scene
from knotfem.scene.model import Scene
from knotfem.solver.nonlinear.newton import Interrupt
from knotfem.solver.term import Term

Out = str | Path | bool | None
"""Folder of a run; True for runs/SCENE-N with the first free N; None or False for none."""
TABLES = ("tie", "tension", "contacts", "twist")
"""What a run that goes on from a tied knot takes over: all but forces, which begin with what loads the knot."""
KEPT = "the error's attribute `run` has the results so far"


def tie(
    source: Scene | str | Path,
    overrides: Overrides = (),
    *,
    out: Out = None,
    force: bool = False,
    progress: Progress | bool = True,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Run:
    """Map the centreline into the knot and let the loose knot come to rest.

    Args:
        source: a scene, or the file or shipped name of one.
        overrides: changes of scene keys, such as {"contact.friction": 0.37}; steps and rods by number or name.
        out: folder for a run directory; True for runs/SCENE-N; None runs in memory.
        force: replace a run that is in the folder.
        progress: whether to show progress: a bar in a terminal or notebook, else a line of the log "knotfem" for each
            step; or an object that is told.
        terms: forces of your own, or functions that make them from the model.
        obstacles: rigid bodies of your own.
        materials: laws of your own for the bulk of hexahedra, by the rod's name.

    Raises:
        KnotfemError: a scene that is wrong, or what ended the run. Ctrl-C and the scene's time limit end it in order.
            Of a run in memory the results so far are the attribute `run` of the error.
    """
    scene, additions = load_scene(source, overrides), _additions(terms, obstacles, materials)
    if _in_memory(out):
        return Task(scene, "tie", additions).run(progress)
    return _run_on_disk(_new(scene, out, force), "tie", additions, progress)


def pull(
    source: Scene | Run | str | Path,
    overrides: Overrides = (),
    *,
    out: Out = None,
    force: bool = False,
    progress: Progress | bool = True,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Run:
    """Take all steps of a scene, tying first what is not tied yet.

    Args:
        source: a scene, a run whose tied knot is taken up, or the file, folder or shipped name of one.
        overrides: changes of scene keys. Of a run that is tied they may concern what comes after tying: other steps,
            friction or effects.
        out: see `tie`; the folder of the run itself to go on in it.
        force: see `tie`.
        progress: see `tie`.
        terms: see `tie`; of a run those that it was begun with and, in another folder or in memory, further ones.
        obstacles: likewise.
        materials: likewise.

    Raises:
        KnotfemError: see `tie`; also a run that was begun with terms, obstacles or materials that are not passed again.
    """
    additions = _additions(terms, obstacles, materials)
    run = _as_run(source)
    if _in_memory(out):
        return _pulling(source if run is None else run, overrides, additions).run(progress)
    if run is None:
        directory = _new(_scene(source, overrides), out, force)
    else:
        directory = _going_on(run, overrides, additions, out, force)
    return _run_on_disk(directory, "pull", additions, progress)


def resume(
    path: str | Path,
    overrides: Overrides = (),
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
        terms: those that the run was begun with; a run directory knows them by name only.
        obstacles: likewise.
        materials: likewise.

    Raises:
        KnotfemError: see `tie`; also a checkpoint of an older version, or other terms, obstacles or materials than the
            run was begun with.
    """
    directory = RunDirectory.open(path)
    if overrides:
        directory.override(overrides)
    return _run_on_disk(directory, goal_of(directory), _additions(terms, obstacles, materials), progress)


def steps(
    source: Scene | Run | str | Path,
    overrides: Overrides = (),
    *,
    terms: Sequence[TermMaker] = (),
    obstacles: Sequence[Obstacle] = (),
    materials: Mapping[str, Any] | None = None,
) -> Iterator[TimeStepDone]:
    """Yield the accepted time steps of a scene as they come, in memory; see `pull` for the arguments.

    Whoever takes them may end whenever they like; Ctrl-C and time limit are theirs.
    """
    run = _as_run(source)
    task = _pulling(source if run is None else run, overrides, _additions(terms, obstacles, materials))
    return (event for event in task.simulation().run() if isinstance(event, TimeStepDone))


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be computed in memory.

    Attributes:
        scene: what to run.
        goal: "tie" or "pull".
        additions: of the user's own.
        earlier: the run whose tied knot is taken up, or None.
        tied: that knot.
    """

    scene: Scene
    goal: str
    additions: Additions
    earlier: Run | None = None
    tied: RunCheckpoint | None = None

    def run(self, progress: Progress | bool) -> Run:
        """Reach the goal."""
        with closing(_progress(progress)) as shown, StopRequest(self.scene.solver.time_limit) as stop:

            def heed_stop() -> None:
                if stop.due:
                    raise stop.error(KEPT)

            simulation, store, tied = self.simulation(heed_stop, shown.message), self._store(), None
            recorder = Recorder(simulation, store)
            recorder.begin(self.tied)

            def made() -> Run:
                return MemoryRun(self.scene, store, recorder.finish(), names_of(self.additions), tied)

            try:
                for event in simulation.run():
                    recorder.record(event)
                    if not isinstance(event, PhaseDone):
                        shown.step(report_of(event))
                    elif event.tied:
                        tied = recorder.checkpoint()
            except KnotfemError as error:
                error.run = made()
                raise
            return made()

    def simulation(self, interrupt: Interrupt | None = None, notify: Callable[[str], None] = LOG.info) -> Simulation:
        """The simulation, at its beginning or at the tied knot."""
        simulation = Simulation(
            self.scene,
            self.goal,
            additions=self.additions,
            source=source_rods(self.scene),
            interrupt=interrupt,
            notify=notify,
        )
        if self.tied is not None:
            simulation.restore(self.tied.simulation)
        return simulation

    def _store(self) -> MemoryStore:
        """Where results go, with those of the run whose tied knot is taken up but for its table of forces."""
        if self.earlier is None or self.tied is None:
            return MemoryStore()
        fields = [(state, state.fields) for state in self.earlier.states[: self.tied.rows["series"]]]
        states = [StoredState(s.time, s.displacement, Fields(f.points, f.point_data, f.cell_data)) for s, f in fields]
        return MemoryStore({name: self.earlier.table(name) for name in self.tied.rows if name in TABLES}, states)


def _run_on_disk(directory: RunDirectory, goal: str, additions: Additions, progress: Progress | bool) -> Run:
    """Bring a run directory to a goal."""
    with closing(_progress(progress)) as shown:
        shown.message(f"run directory {directory.path}")
        with directory.locked():
            drive(directory, goal, shown, additions=additions, figures=RunFigures())
    return open_run(directory.path)


def _additions(
    terms: Sequence[TermMaker], obstacles: Sequence[Obstacle], materials: Mapping[str, Any] | None
) -> Additions:
    for kind, objects in (("terms", terms), ("obstacles", obstacles)):
        if isinstance(objects, str) or not isinstance(objects, Sequence):
            raise InputError("not a list", key=kind, found=type(objects).__name__, expected=f"a list, {kind}=[...]")
    for term in terms:
        if isinstance(term, type) or not (isinstance(term, Term) or callable(term)):
            raise no_term(term)
    for obstacle in obstacles:
        if not isinstance(obstacle, Obstacle):
            raise InputError("no obstacle", key="obstacles", found=repr(obstacle), expected="a knotfem.Obstacle")
    return Additions(terms, obstacles, dict(materials or {}))


def _pulling(source: Scene | Run | str | Path, overrides: Overrides, additions: Additions) -> Task:
    """Take all steps of a scene, or those after tying from a run's tied knot."""
    scene = _scene(source, overrides)
    if not isinstance(source, Run):
        return Task(scene, "pull", additions)
    require(source.additions, names_of(additions), source.path, same=False)
    tied = source.tied()
    if tied is None:
        return Task(scene, "pull", additions)
    RunDirectory.check_branch(source.scene, scene, source.path)
    return Task(scene, "pull", additions, source, tied)


def _scene(source: Scene | Run | str | Path, overrides: Overrides) -> Scene:
    return load_scene(source.scene if isinstance(source, Run) else source, overrides)


def _as_run(source: Scene | Run | str | Path) -> Run | None:
    if not isinstance(source, str | Path):
        return source if isinstance(source, Run) else None
    return open_run(source) if RunDirectory.means_run(source) else None


def _in_memory(out: Out) -> bool:
    return out is None or out is False


def _folder(out: Out) -> Path | None:
    """The folder that is named; None for one of runs/."""
    return None if isinstance(out, bool) or out is None else Path(out)


def _new(scene: Scene, out: Out, force: bool) -> RunDirectory:
    """The folder of a new run, made once the run that it sets out from is known to be right."""
    folder = _folder(out)
    if scene.tie.source is not None:
        source_rods(scene)
        if folder is not None and folder.resolve() == Path(scene.tie.source):
            raise _replaces(folder)
    return RunDirectory.create(scene, folder, force=force)


def _going_on(run: Run, overrides: Overrides, additions: Additions, out: Out, force: bool) -> RunDirectory:
    """The folder in which a run goes on: its own, or another with its tied knot."""
    folder = _folder(out)
    if run.path is None:
        raise InputError("a run in memory has no files to go on from", expected="a run that was made with out=")
    directory = RunDirectory.open(run.path)
    if folder is not None and folder.resolve() == directory.path.resolve():
        if force:
            raise _replaces(folder)
        if overrides:
            directory.override(overrides)
        return directory
    require(run.additions, names_of(additions), run.path, same=False)
    scene = load_scene(directory.scene_file, overrides)
    if not directory.tied:
        return _new(scene, out, force)
    run.tied()  # that it can be read is known before a folder is made
    return directory.branch(scene, folder, force=force)


def _replaces(folder: Path) -> InputError:
    return InputError("the run would replace its source", file=folder, expected="another folder")


def _progress(progress: Progress | bool) -> Progress:
    return automatic_progress(shown=progress) if isinstance(progress, bool) else progress
