"""The list of a run's stored states: of which step, at which displacement and time, and which one is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from knotfem.errors import InputError
from knotfem.plot.fonts import literal
from knotfem.run.columns import RUNNING
from knotfem.types import Arrays


@dataclass(frozen=True)
class Moment:
    """When a stored state was.

    Attributes:
        step: name of the scene's step; "" where an older run does not tell.
        displacement: of the reported end over all steps after tying [mm].
        step_displacement: since the step began [mm].
        time: [s].
    """

    step: str
    displacement: float
    step_displacement: float
    time: float

    def __str__(self) -> str:
        of_step = f" of {self.step}" if self.step else ""
        within = f" ({self.step_displacement:.6g} mm in this step)" if self._apart else ""
        return f"{self.displacement:.6g} mm{of_step}{within}, {self.time:.6g} s"

    @property
    def _apart(self) -> bool:
        return not np.isclose(self.displacement, self.step_displacement, rtol=1e-9, atol=1e-9)


def moment_heading(moment: Moment) -> str:
    """A stored state as the heading of a figure."""
    place = rf"$\delta$ = {moment.displacement:.4g} mm" if np.isfinite(moment.displacement) else ""
    return ", ".join(part for part in (place, literal(moment.step)) if part)


class AtMoment:
    """What was read from one stored state.

    Attributes:
        moment: when it was.
    """

    moment: Moment

    @property
    def time(self) -> float:
        """Time [s]."""
        return self.moment.time

    @property
    def displacement(self) -> float:
        """Of the reported end over all steps after tying [mm]; nan where it is not known."""
        return self.moment.displacement


def moments_of(table: Arrays) -> list[Moment]:
    """The states of a table with displacements and times, by ascending time."""
    if "time_s" not in table or "displacement_mm" not in table:
        return []
    times, first = np.unique(table["time_s"], return_index=True)
    there = table["displacement_mm"][first].tolist()
    steps = table["step"][first].tolist() if "step" in table else [""] * len(there)
    within = table[RUNNING][first].tolist() if RUNNING in table else there
    rows = zip(steps, there, within, times.tolist(), strict=True)
    return [Moment(str(step), d, own, time) for step, d, own, time in rows]


def choose(moments: Sequence[Moment], at: float | None, step: str | None, path: Path | None) -> Moment:
    """The stored state that is asked for: the nearest to a displacement, or the last, of all steps or of one.

    Args:
        moments: of the stored states, at least one, by ascending time.
        at: displacement over all steps [mm], or None for the last.
        step: name of the step that the state is to be of, or None.
        path: of the run, for messages.

    Raises:
        InputError: no state of this step is stored, or the displacement is less than the smallest or more than the
            largest that is stored.
    """
    if step is not None:
        names = [name for name in dict.fromkeys(moment.step for moment in moments) if name]
        if step not in names:
            expected = ", ".join(names) or "none, since this run is of an older version"
            problem = "no state of this step is stored"
            raise InputError(problem, file=path, key="step", found=f'"{step}"', expected=expected)
        moments = [moment for moment in moments if moment.step == step]
    if at is None:
        return moments[-1]
    low, high = (end(moment.displacement for moment in moments) for end in (min, max))
    slack = 1e-6 * max(1.0, abs(at))
    if not low - slack <= at <= high + slack:
        problem, expected = "no state is stored near this displacement", reach(moments)
        raise InputError(problem, file=path, key="at", found=f"{at:g} mm", expected=expected)
    return min(moments, key=lambda moment: abs(moment.displacement - at))


def reach(moments: Sequence[Moment]) -> str:
    """Displacements of stored states, in words."""
    low, high = (end(moment.displacement for moment in moments) for end in (min, max))
    return f"{low:g} mm" if low == high else f"{low:g} to {high:g} mm"
