"""The points of a curve as a file holds them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from knotfem.geometry.length_units import LengthUnit
from knotfem.types import Array


@dataclass(frozen=True, eq=False)
class Polyline:
    """Points of one curve, and where they stand in their file.

    Attributes:
        points: shape (n, 3), in the units of the file.
        numbers: of the points in the curve, from 1, shape (n,).
        lines: of the file in which they stand, from 1, shape (n,).
        closed: whether the file says that the last point is joined to the first.
        unit: of the coordinates; None if the file has none.
        unit_from: what gives it, such as the head of a column.
        radii: of the rod at the points, shape (n,), in the unit of the coordinates or their own; None if the file has
            none.
        radius_unit: of the radii if they have one of their own.
        unused: names of columns that are left out.
        unknown_unit: head of a column of coordinates whose unit is none of length; empty for none.
    """

    points: Array
    numbers: NDArray[np.int64]
    lines: NDArray[np.int64]
    closed: bool = False
    unit: LengthUnit | None = None
    unit_from: str = ""
    radii: Array | None = None
    radius_unit: LengthUnit | None = None
    unused: tuple[str, ...] = ()
    unknown_unit: str = ""

    def __len__(self) -> int:
        """Number of points."""
        return len(self.points)

    def taken(self, rows: NDArray[np.int64], *, closed: bool | None = None) -> Polyline:
        """Some of its points, in the order of their rows, shape (m,)."""
        return replace(
            self,
            points=self.points[rows],
            numbers=self.numbers[rows],
            lines=self.lines[rows],
            radii=None if self.radii is None else self.radii[rows],
            closed=self.closed if closed is None else closed,
        )

    @property
    def chords(self) -> Array:
        """Lengths of the chords between its points, shape (n - 1,)."""
        return np.linalg.norm(np.diff(self.points, axis=0), axis=1)

    @property
    def median_chord(self) -> float:
        """Of chords that are not zero."""
        chords = self.chords
        return float(np.median(chords[chords > 0.0])) if (chords > 0.0).any() else 0.0

    def named(self, first: int, second: int) -> str:
        """Two of its points, by their rows, for a message."""
        lines = f"lines {self.lines[first]} and {self.lines[second]}"
        return f"points {self.numbers[first]} and {self.numbers[second]} ({lines})"


def polyline(points: Array, lines: NDArray[np.int64], *, closed: bool = False) -> Polyline:
    """A curve of points, numbered one after the other."""
    return Polyline(points, np.arange(1, len(points) + 1), lines, closed)
