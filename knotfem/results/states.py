"""Stored states of a run with their fields."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from knotfem.results.fields import StateFields
from knotfem.run.directory import RunDirectory
from knotfem.run.frames import read_frame, read_mesh, read_times
from knotfem.run.memory import MemoryStore
from knotfem.run.tables import read_table
from knotfem.scene.model import Scene


@dataclass(frozen=True, eq=False)
class RunState:
    """A stored state.

    Attributes:
        scene: of the run.
        time: [s].
        displacement: of the reported end since the start of the scene's step [mm]; nan where it is not known.
        read: reads mesh and fields.
    """

    scene: Scene
    time: float
    displacement: float
    read: Callable[[], StateFields]

    @property
    def fields(self) -> StateFields:
        """Mesh and fields, read anew each time."""
        return self.read()

    @property
    def points(self) -> np.ndarray:
        """Places [mm], shape [points, 3]."""
        return self.fields.points

    def render(self, out: str | Path, colour: str = "strain") -> None:
        """Draw the rods into a PNG file; see `knotfem.results.pictures.draw`."""
        from knotfem.results.pictures import draw

        draw(self.fields, self.scene, Path(out), colour)

    def show(self, colour: str = "strain") -> object:
        """Show the rods in a window or a notebook; see `knotfem.results.pictures.show`."""
        from knotfem.results.pictures import show

        return show(self.fields, self.scene, colour)


def disk_states(run: RunDirectory) -> Sequence[RunState]:
    """States of a run directory's time series; none without one."""
    path = run.path / "results.vtkhdf"
    if not path.exists():
        return []
    known = _displacements(run)

    def reader(step: int) -> Callable[[], StateFields]:
        def read() -> StateFields:
            frame, (reference, cells) = read_frame(path, step), read_mesh(path)
            return StateFields(frame.points, reference, cells, frame.point_data, frame.cell_data)

        return read

    times = read_times(path)
    return [RunState(run.scene, float(t), known.get(float(t), float("nan")), reader(i)) for i, t in enumerate(times)]


def memory_states(scene: Scene, store: MemoryStore) -> Sequence[RunState]:
    """States of a run in memory."""
    if store.states is None:
        return []
    mesh = store.states.mesh

    def reader(number: int) -> Callable[[], StateFields]:
        def read() -> StateFields:
            assert store.states is not None
            fields = store.states.states[number].fields
            data = {**mesh.point_data, **fields.point_data}
            return StateFields(fields.points, mesh.reference, mesh.cells, data, fields.cell_data)

        return read

    return [RunState(scene, s.time, s.displacement, reader(i)) for i, s in enumerate(store.states.states)]


def _displacements(run: RunDirectory) -> dict[float, float]:
    path = run.path / "tension.csv"
    table = read_table(path) if path.exists() else {}
    if not table or not table["time_s"].size:
        return {}
    times, first = np.unique(table["time_s"], return_index=True)
    return dict(zip(times.tolist(), table["displacement_mm"][first].tolist(), strict=True))
