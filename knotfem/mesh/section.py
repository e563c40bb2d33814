"""Cross-section of a rod: quadrilaterals that fill a disc of unit radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def regular_polygon(sides: int) -> FloatArray:
    """Points of the unit circle at equal angles, counter-clockwise from angle 0, shape (sides, 2)."""
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.column_stack([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True, eq=False)
class Section:
    """Quadrilaterals that fill the regular polygon inscribed in the unit circle.

    Attributes:
        points: node positions in units of the node radius, shape (m, 2).
        quads: nodes of each quadrilateral, shape (q, 4): corners, counter-clockwise; or (q, 9): the corners, the
            middles of the edges from each corner to the next, and the centre.
        axis: the node at the origin.
        ring: boundary nodes, counter-clockwise at equal angles, the first at angle 0, shape (k,).
    """

    points: FloatArray
    quads: IntArray
    axis: int
    ring: IntArray

    @property
    def sides(self) -> int:
        """Number of nodes of the boundary."""
        return len(self.ring)

    @property
    def order(self) -> int:
        """Order of the quadrilaterals: 1 of four nodes, 2 of nine."""
        return 1 if self.quads.shape[1] == 4 else 2
