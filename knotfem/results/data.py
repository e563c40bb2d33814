"""Results of a run on disk and in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.results.run import Run
from knotfem.results.states import RunState, disk_states, memory_states
from knotfem.run.checkpoint import RunCheckpoint, read_checkpoint
from knotfem.run.directory import RunDirectory
from knotfem.run.memory import MemoryStore
from knotfem.run.tables import read_table
from knotfem.scene.load import Overrides
from knotfem.scene.model import Scene

Table = Mapping[str, np.ndarray]


class DiskData:
    """Results in a run directory; see `knotfem.results.run.RunData`.

    Args:
        directory: of the run.
    """

    def __init__(self, directory: RunDirectory) -> None:
        self.directory = directory

    @property
    def scene(self) -> Scene:
        """The resolved scene."""
        return self.directory.scene

    @property
    def path(self) -> Path:
        """The run directory."""
        return self.directory.path

    def table(self, name: str) -> Table:
        """The table NAME.csv."""
        path = self.path / f"{name}.csv"
        return read_table(path) if path.exists() else {}

    def summary(self) -> dict[str, Any]:
        """The file summary.json."""
        return self.directory.read_summary() if (self.path / "summary.json").exists() else {}

    def states(self) -> Sequence[RunState]:
        """States of results.vtkhdf."""
        return disk_states(self.directory)

    def checkpoint(self, name: str) -> RunCheckpoint | None:
        """What a checkpoint holds."""
        store = self.directory.checkpoints
        path = store.named(name) if name else None
        found = read_checkpoint(path) if path is not None else None if name else store.latest()
        return None if found is None else RunCheckpoint.of(found)


class MemoryData:
    """Results in memory; see `knotfem.results.run.RunData`.

    Args:
        scene: that was run.
        store: of the recorder.
        summary: figures of the run.
        checkpoints: by name, the last as "".
    """

    path = None

    def __init__(
        self, scene: Scene, store: MemoryStore, summary: dict[str, Any], checkpoints: Mapping[str, RunCheckpoint]
    ) -> None:
        self.scene, self.store = scene, store
        self._summary, self._checkpoints = summary, checkpoints
        self.table = cache(self._table)

    def _table(self, name: str) -> Table:
        """Columns of a table."""
        table = self.store.tables.get(name)
        return {} if table is None else table.arrays()

    def summary(self) -> dict[str, Any]:
        """Figures of the run."""
        return self._summary

    def states(self) -> Sequence[RunState]:
        """States whose fields are kept."""
        return memory_states(self.scene, self.store)

    def checkpoint(self, name: str) -> RunCheckpoint | None:
        """State of the run."""
        return self._checkpoints.get(name)


def open_run(path: str | Path, overrides: Overrides = ()) -> Run:
    """The results in a run directory.

    Args:
        path: the folder.
        overrides: changes of keys under solver and output with which it is to go on.

    Raises:
        InputError: no run is there, or an override of something else.
    """
    directory = RunDirectory.open(path)
    if overrides:
        directory.override(overrides)
    return Run(DiskData(directory), directory.path.resolve().name)
