"""Mesh and fields of a stored state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class StateFields:
    """Mesh and fields of a state.

    Attributes:
        points: places [mm], shape [points, 3].
        reference: of the straight rods [mm], shape [points, 3].
        cells: points of each cell, shape [cells, n].
        point_data: arrays on points by name.
        cell_data: arrays on cells by name.
    """

    points: np.ndarray
    reference: np.ndarray
    cells: np.ndarray
    point_data: dict[str, np.ndarray]
    cell_data: dict[str, np.ndarray]
