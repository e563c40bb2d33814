"""Runs on disk and in memory."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from knotfem.models.series import Fields
from knotfem.results.fields import StateFields
from knotfem.results.moment import Moment, moments_of
from knotfem.results.older import running, running_forces
from knotfem.results.run import Run
from knotfem.results.states import RunState
from knotfem.run.checkpoint import RunCheckpoint, read_checkpoint
from knotfem.run.directory import TIED, RunDirectory
from knotfem.run.frames import read_frame, read_mesh, read_times
from knotfem.run.memory import MemoryStore
from knotfem.run.provenance import Provenance
from knotfem.run.tables import read_table
from knotfem.scene.load import Overrides
from knotfem.scene.model import Scene
from knotfem.types import Arrays

_LOG = logging.getLogger("knotfem")


class DiskRun(Run):
    """A run directory.

    Args:
        directory: of the run.
    """

    def __init__(self, directory: RunDirectory) -> None:
        self.name, self.path = directory.path.resolve().name, directory.path
        self._directory = directory
        self._tables: dict[str, Arrays] = {}

    @property
    def scene(self) -> Scene:
        return self._directory.scene

    def table(self, name: str) -> Arrays:
        if name not in self._tables:
            file = self._directory.path / f"{name}.csv"
            table = read_table(file) if file.exists() else {}
            self._tables[name] = running_forces(table) if name == "force" else running(table, self.table("force"))
        return self._tables[name]

    @property
    def summary(self) -> dict[str, Any]:
        return self._directory.read_summary() if (self._directory.path / "summary.json").exists() else {}

    def _read_states(self) -> list[RunState]:
        file = self._directory.path / "results.vtkhdf"
        if not file.exists():
            return []
        known = {moment.time: moment for moment in moments_of(self.table("tension"))}

        def reader(step: int) -> Callable[[], StateFields]:
            def read() -> StateFields:
                frame, (reference, cells) = read_frame(file, step), read_mesh(file)
                return StateFields(frame.points, reference, cells, frame.point_data, frame.cell_data)

            return read

        times = read_times(file).tolist()
        return [RunState(self.scene, known.get(time, _unknown(time)), reader(i)) for i, time in enumerate(times)]

    @property
    def additions(self) -> Mapping[str, Sequence[str]]:
        return Provenance(self._directory.path).additions or {}

    def tied(self) -> RunCheckpoint | None:
        file = self._directory.checkpoints.named(TIED)
        return None if file is None else RunCheckpoint.of(read_checkpoint(file))


class MemoryRun(Run):
    """A run in memory.

    Args:
        scene: that was run.
        store: of the recorder.
        summary: figures of the run.
        additions: names of what the user added to the scene as objects.
        tied: the tied knot, or None.
    """

    path: Path | None = None

    def __init__(
        self,
        scene: Scene,
        store: MemoryStore,
        summary: dict[str, Any],
        additions: Mapping[str, Sequence[str]],
        tied: RunCheckpoint | None,
    ) -> None:
        self.name = scene.name
        self._scene, self._summary, self._additions, self._tied = scene, summary, additions, tied
        self._tables = {name: table.arrays() for name, table in store.tables.items()}
        self._series = store.states

    @property
    def scene(self) -> Scene:
        return self._scene

    def table(self, name: str) -> Arrays:
        return self._tables.get(name, {})

    @property
    def summary(self) -> dict[str, Any]:
        return self._summary

    def _read_states(self) -> list[RunState]:
        if self._series is None:
            return []
        mesh = self._series.mesh

        def reader(fields: Fields) -> Callable[[], StateFields]:
            def read() -> StateFields:
                data = {**mesh.point_data, **fields.point_data}
                return StateFields(fields.points, mesh.reference, mesh.cells, data, fields.cell_data)

            return read

        known = {moment.time: moment for moment in moments_of(self.table("tension"))}
        states = self._series.states
        return [RunState(self.scene, known.get(s.time, _unknown(s.time)), reader(s.fields)) for s in states]

    @property
    def additions(self) -> Mapping[str, Sequence[str]]:
        return self._additions

    def tied(self) -> RunCheckpoint | None:
        return self._tied


def _unknown(time: float) -> Moment:
    """A stored state of which tables know the time only."""
    return Moment("", float("nan"), float("nan"), time)


def open_run(path: str | Path, overrides: Overrides = ()) -> Run:
    """The results in a run directory.

    A warning of the log "knotfem" tells of a name, not of a Path, that is a shipped scene's too.

    Args:
        path: the folder.
        overrides: changes of keys under solver and output with which it is to go on.

    Raises:
        InputError: no run is there, its scene was changed after it had run, or an override of something else.
    """
    directory = RunDirectory.open(path)
    directory.check_scene()
    shadowed = RunDirectory.shadowed(path) if isinstance(path, str) else None
    if shadowed is not None:
        _LOG.warning(shadowed)
    if overrides:
        directory.override(overrides)
    return DiskRun(directory)
