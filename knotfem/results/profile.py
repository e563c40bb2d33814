"""Tension along the centreline, read back from tension.csv."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from knotfem.errors import InputError
from knotfem.results.base import RunData, frame_of
from knotfem.results.moment import AtMoment, Moment, choose, moment_heading, moments_of
from knotfem.types import Arrays

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEEDED = ("time_s", "displacement_mm", "s_over_L", "tension_N")
"""Columns without which tension.csv says nothing."""


@dataclass(frozen=True, eq=False)
class TensionProfile(AtMoment):
    """Tension along the centreline in one state.

    Attributes:
        table: columns of tension.csv, one state's rows.
        moment: when it was.
    """

    table: dict[str, np.ndarray]
    moment: Moment

    def __repr__(self) -> str:
        return f"<tension profile at {self.moment}, {len(self.tension)} sections of {', '.join(self.rods)}>"

    @property
    def arclength(self) -> np.ndarray:
        """From the start of each rod [mm], shape [sections of all rods]."""
        return self.table["arclength_mm"]

    @property
    def tension(self) -> np.ndarray:
        """Sum of nodal forces along the centreline [N], shape [sections of all rods]."""
        return self.table["tension_N"]

    @property
    def rods(self) -> list[str]:
        """Names of the rods; a table that does not name them is of one."""
        return list(dict.fromkeys(self.table["rod"].tolist())) if "rod" in self.table else ["rod"]

    def of(self, rod: str) -> TensionProfile:
        """The part of one rod."""
        if "rod" not in self.table:
            return self
        rows = self.table["rod"] == rod
        return TensionProfile({k: v[rows] for k, v in self.table.items()}, self.moment)

    def to_pandas(self) -> object:
        """A pandas DataFrame with the columns of tension.csv.

        Raises:
            MissingDependency: pandas is not installed.
        """
        return frame_of(self.table)

    def plot(self, axes: Axes | None = None, **line: object) -> Axes:
        """Tension [N] against arclength [mm], a line for each rod; a figure of its own says which state it shows."""
        from knotfem.plot.axes import axes_for
        from knotfem.plot.curves import ARCLENGTH_LABELS, TENSION_LABELS

        with axes_for(axes) as drawn:
            for rod in self.rods:
                part = self.of(rod)
                drawn.plot(part.arclength, part.tension, **{"label": rod, **line})  # pyright: ignore[reportArgumentType]
            drawn.set(xlabel=ARCLENGTH_LABELS["arclength_mm"], ylabel=TENSION_LABELS["N"])
            if axes is None:
                drawn.set_xlim(left=0.0)
                drawn.set_title(moment_heading(self.moment))
        return drawn


@dataclass(frozen=True, eq=False)
class StoredStates:
    """States whose profiles are stored.

    Attributes:
        path: of the run.
        table: its columns.
        moments: when they were, by ascending time.
    """

    path: Path | None
    table: Arrays
    moments: list[Moment]

    @classmethod
    def of(cls, path: Path | None, table: Arrays) -> StoredStates:
        """Those of a table with times and displacements; none of an empty one."""
        return cls(path, table, moments_of(table))

    @property
    def times(self) -> np.ndarray:
        """Of all states [s], ascending."""
        return np.array([moment.time for moment in self.moments])

    @property
    def displacements(self) -> np.ndarray:
        """Of the reported end over all steps after tying at those times [mm]."""
        return np.array([moment.displacement for moment in self.moments])

    def choose(self, at: float | None = None, step: str | None = None) -> Moment:
        """The state that is asked for; see `knotfem.results.moment.choose`."""
        return choose(self.moments, at, step, self.path)

    def profile(self, at: float | None = None, step: str | None = None) -> TensionProfile:
        """Tension profile of the state that is asked for; see `choose`."""
        moment = self.choose(at, step)
        return TensionProfile(self.at_time(moment.time), moment)

    def at_time(self, time: float) -> dict[str, np.ndarray]:
        """Rows of the state that is stored at a time [s]."""
        rows = self.table["time_s"] == time
        return {name: values[rows] for name, values in self.table.items()}


def stored_states(run: RunData) -> StoredStates:
    """The states of a run whose profiles are stored.

    Raises:
        InputError: there are none.
    """
    table = run.table("tension")
    if not table or not table["time_s"].size:
        raise InputError("no tension is stored yet", file=run.path, expected="a run that knotfem pull has brought on")
    for column in NEEDED:
        if column not in table:
            raise InputError("no such column", file=run.path, key=column, found=",".join(table))
    return StoredStates.of(run.path, table)
