"""Time series of a deforming rod as one VTKHDF file, for ParaView 5.12 or newer and for the program's own pictures.

It is written here, and not by VTK's own vtkHDFWriter, since a run adds one step at a time and may be killed at any
moment. That writer (VTK 9.7, tried) takes all steps from a pipeline in one call, replaces or refuses a file that exists
instead of adding to it, and leaves one that HDF5 cannot open when the process is killed between two steps, also
where each step goes into a file of its own.
"""

from __future__ import annotations

import os
import shutil
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from knotfem.errors import cannot_write
from knotfem.files import write_atomically
from knotfem.run.frames import Frame, read_times
from knotfem.run.hdf_layout import append_frame, as_stored, stored_bytes, truncate, write_constant, write_mesh
from knotfem.types import Array, Arrays, Index

_NOTHING: Arrays = {}
_METADATA = 1 << 20  # bytes, well above what HDF5 adds to the arrays of a step


class VtkHdfSeries:
    """Appends steps to a VTKHDF file (version 2.0, transient UnstructuredGrid) with h5py alone.

    Connectivity is stored once. Points move with the steps, so that ParaView shows the deformed rod without a filter;
    the point array `displacement` from the reference is added to every step. Positions are float64, other arrays
    float32, a chunk a step, deflated.

    The file under its name is complete at any moment, whatever ends the process: each step goes into a second, hidden
    copy that lags one step behind, and the two then change names. The price is twice the space while a run lasts; the
    copy is removed by `close`. Where the file system has no hard links, the copy is made anew each step.

    Args:
        path: an existing series, to be continued; `create` starts a new one.

    Raises:
        InputError: the file is missing or not such a series.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._spare = self.path.with_name(f".{self.path.name}.spare")
        self._swap = self.path.with_name(f".{self.path.name}.swap")
        self._lagging: list[Frame] = []
        self._drop_spare()
        self.times = read_times(self.path)

    @classmethod
    def create(
        cls,
        path: str | Path,
        reference: Array,
        cells: Index,
        *,
        point_data: Arrays = _NOTHING,
        cell_data: Arrays = _NOTHING,
    ) -> VtkHdfSeries:
        """Start a series, replacing a file of that name.

        Args:
            path: file to write.
            reference: positions from which displacements count, in mm, shape (N, 3).
            cells: points of each cell in VTK order, shape (E, 8) for hexahedra, (E, 4) for quadrilaterals.
            point_data: arrays on points that never change (arclength, number of the rod).
            cell_data: arrays on cells that never change.

        Raises:
            InputError: the file cannot be written.
        """
        import h5py

        path = Path(path)
        buffer = BytesIO()
        with h5py.File(buffer, "w") as file:
            write_mesh(file, np.asarray(reference, dtype=np.float64), np.asarray(cells))
            for kind, arrays in (("PointData", point_data), ("CellData", cell_data)):
                for name, values in arrays.items():
                    write_constant(file["VTKHDF"], kind, name, values)
        write_atomically(path, buffer.getvalue())
        return cls(path)

    def append(
        self,
        time: float,
        points: Array,
        *,
        point_data: Arrays = _NOTHING,
        cell_data: Arrays = _NOTHING,
        displacement: float = float("nan"),
    ) -> None:
        """Add a step; all steps carry the same arrays.

        Args:
            time: time in s, later than the last step's.
            points: positions in mm, shape (N, 3).
            point_data: arrays on points, such as `contact_pressure` in MPa, shape (N,) or (N, c).
            cell_data: arrays on cells, such as `stress` in MPa, shape (E, 6) in ParaView's order xx yy zz xy yz xz,
                `largest_principal_strain` or `pressure`, shape (E,).
            displacement: of the reported end [mm].

        Raises:
            InputError: the disk is full or the file cannot be written; the steps before are kept.
            ValueError: the arrays do not fit the mesh or the steps before, or time does not go on.
        """
        if len(self.times) and not time > self.times[-1]:
            raise ValueError(f"time {time} does not follow {self.times[-1]}")
        frame = Frame(
            float(time),
            np.array(points, dtype=np.float64),
            {name: as_stored(values) for name, values in point_data.items()},
            {name: as_stored(values) for name, values in cell_data.items()},
            displacement,
        )
        if not self._spare.exists():
            self._lagging = []
            _copy(self.path, self._spare)
        try:
            frames = (*self._lagging, frame)
            with _Writing(self.path, self._spare, sum(stored_bytes(f) for f in frames)) as root:
                for missing in frames:
                    append_frame(root, missing)
            self._publish()
        except BaseException:
            self._drop_spare()
            self.times = read_times(self.path)
            raise
        self._lagging = [frame] if self._spare.exists() else []
        self.times = np.append(self.times, frame.time)

    def truncate(self, steps: int) -> None:
        """Keep only the first steps, as a resumed run needs.

        Raises:
            ValueError: there are not that many steps.
            InputError: the file cannot be written.
        """
        if not 0 <= steps <= len(self.times):
            raise ValueError(f"{steps} steps asked for, {len(self.times)} stored")
        if steps == len(self.times):
            return
        self._drop_spare()
        _copy(self.path, self._spare)
        with _Writing(self.path, self._spare) as root:
            truncate(root, steps)
        _sync_and_replace(self._spare, self.path)
        self._lagging = []
        self.times = self.times[:steps]

    def close(self) -> None:
        """Remove the hidden copy."""
        self._drop_spare()

    def __enter__(self) -> VtkHdfSeries:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _publish(self) -> None:
        """Exchange the names of the file and of its copy; the file's name is never without a complete file."""
        try:
            os.link(self.path, self._swap)
        except OSError:
            _sync_and_replace(self._spare, self.path)
            return
        _sync_and_replace(self._spare, self.path)
        self._swap.replace(self._spare)

    def _drop_spare(self) -> None:
        self._spare.unlink(missing_ok=True)
        self._swap.unlink(missing_ok=True)
        self._lagging = []


class _Writing:
    """A series open for writing, with space reserved: HDF5 does not survive a full disk, it crashes at exit."""

    def __init__(self, known_as: Path, path: Path, need: int = 0) -> None:
        self.known_as, self.path, self.need = known_as, path, need

    def __enter__(self) -> Any:
        import h5py

        try:
            _reserve(self.path, self.need + _METADATA)
            self.file = h5py.File(self.path, "r+", locking=False)
        except OSError as error:
            self.path.unlink(missing_ok=True)
            raise cannot_write(self.known_as, error) from error
        return self.file["VTKHDF"]

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.file.close()


def _reserve(path: Path, size: int) -> None:
    """Lengthen a file by zeros, which HDF5 overwrites and cuts off when it closes the file."""
    with path.open("ab") as file:
        for start in range(0, size, _METADATA):
            file.write(bytes(min(_METADATA, size - start)))


def _copy(source: Path, target: Path) -> None:
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        target.unlink(missing_ok=True)
        raise cannot_write(source, error) from error


def _sync_and_replace(source: Path, target: Path) -> None:
    try:
        with source.open("rb+") as file:
            os.fsync(file.fileno())
        source.replace(target)
    except OSError as error:
        raise cannot_write(target, error) from error
