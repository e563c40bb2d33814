"""Meshes and fields of stored states, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SeriesMesh:
    """The mesh of a time series.

    Attributes:
        reference: places of its points [mm], shape [points, 3].
        cells: points of each cell, shape [cells, 8 or 27] for hexahedra, [cells, 4] for quadrilaterals.
        point_data: arrays on points that never change.
    """

    reference: np.ndarray
    cells: np.ndarray
    point_data: dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Fields:
    """Fields of a state for the time series.

    Attributes:
        points: places [mm], shape [points, 3].
        point_data: arrays on points.
        cell_data: arrays on cells.
    """

    points: np.ndarray
    point_data: dict[str, np.ndarray]
    cell_data: dict[str, np.ndarray]
