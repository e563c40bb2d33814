"""Reading back the time series of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.types import Array, Index


@dataclass(frozen=True, eq=False)
class Frame:
    """One stored step.

    Attributes:
        time: time in s.
        points: positions in mm, shape (N, 3).
        point_data: arrays on points, each of N rows.
        cell_data: arrays on cells, each of E rows.
        displacement: of the reported end over all steps after tying [mm]; nan where it is not stored.
    """

    time: float
    points: Array
    point_data: dict[str, NDArray[Any]]
    cell_data: dict[str, NDArray[Any]]
    displacement: float = float("nan")


def read_times(path: str | Path) -> Array:
    """Times of the stored steps in s, shape (steps,).

    Raises:
        InputError: the file is missing or not a series.
    """
    with _Reading(path) as root:
        return np.asarray(root["Steps/Values"][: int(root["Steps"].attrs["NSteps"])], dtype=np.float64)


def read_mesh(path: str | Path) -> tuple[Array, Index]:
    """Reference positions in mm, shape (N, 3), and points of the cells, shape (E, 8) or (E, 4), of a series.

    Raises:
        InputError: the file is missing or not a series.
    """
    with _Reading(path) as root:
        reference = np.asarray(root.file["knotfem/reference"], dtype=np.float64)
        return reference, np.asarray(root["Connectivity"], dtype=np.int64).reshape(int(root["NumberOfCells"][0]), -1)


def read_frame(path: str | Path, step: int = -1) -> Frame:
    """One stored step of a series, the last by default.

    Raises:
        InputError: the file is missing or not a series, or has no such step.
    """
    with _Reading(path) as root:
        steps = int(root["Steps"].attrs["NSteps"])
        if not -steps <= step < steps:
            raise InputError("no such step in the series", file=path, found=step, expected=f"one of {steps} steps")
        step %= steps
        count = {"Point": int(root["NumberOfPoints"][0]), "Cell": int(root["NumberOfCells"][0])}
        arrays: dict[str, dict[str, NDArray[Any]]] = {}
        for kind, rows in count.items():
            arrays[kind] = {}
            for name, data in root[f"{kind}Data"].items():
                start = int(root[f"Steps/{kind}DataOffsets/{name}"][step])
                arrays[kind][name] = np.asarray(data[start : start + rows])
        start = int(root["Steps/PointOffsets"][step])
        points = np.asarray(root["Points"][start : start + count["Point"]], dtype=np.float64)
        stored = "FieldData" in root
        displacement = float(root["FieldData/displacement_mm"][step]) if stored else float("nan")
        return Frame(float(root["Steps/Values"][step]), points, arrays["Point"], arrays["Cell"], displacement)


class _Reading:
    """The VTKHDF group of a series, open for reading."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    def __enter__(self) -> Any:
        import h5py

        if not self.path.is_file():
            raise InputError("no such results file", file=self.path)
        try:
            self.file = h5py.File(self.path, "r", locking=False)
        except OSError as error:
            raise InputError("damaged, or not an HDF5 file", file=self.path) from error
        if "VTKHDF/Steps" not in self.file or "knotfem/reference" not in self.file:
            self.file.close()
            raise InputError("not a time series written by knotfem", file=self.path)
        return self.file["VTKHDF"]

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.file.close()
