"""The time series that ParaView opens."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from knotfem.models.base import SeriesMesh


def open_series(path: Path, make_mesh: Callable[[], SeriesMesh], steps: int | None):
    """The series of a run: a new one, or an existing one cut back to `steps`."""
    from knotfem.run.vtkhdf import VtkHdfSeries

    if steps is not None and path.exists():
        series = VtkHdfSeries(path)
        series.truncate(steps)
        return series
    mesh = make_mesh()
    return VtkHdfSeries.create(path, mesh.reference, mesh.cells, point_data=mesh.point_data)
