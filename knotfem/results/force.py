"""Force of a run, step by step and over all its pulls, and where a knot begins to lock."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from knotfem.errors import InputError
from knotfem.models.plausible import PROMISED
from knotfem.results.base import RunData, displacement_of, frame_of
from knotfem.results.moment import Moment
from knotfem.run.columns import RUNNING
from knotfem.scene.steps import Pull
from knotfem.solver.nonlinear.tolerance import ForceTolerance

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LOCKING_SLOPE = 4.0
"""A knot begins to lock where the force rises this many times faster than it does in the middle of its first half."""


@dataclass(frozen=True, eq=False)
class ForceCurve:
    """What a run's loading steps have brought.

    Attributes:
        label: of the run.
        run: whose they are.
        steps: times [s] and forces [N] of each step, by its name.
        displacement: in pulls, of the reported end over all steps after tying [mm], ascending, shape [n]; empty without
            a pull.
        force: [N], shape [n].
        spans: first and last time [s] of each pull, and the displacement at which it set out [mm], by its name.
        unbalanced: displacements between which the curve is not one of equilibria, as the scene asks for them [mm].
        band: root mean square error that was measured for the settings [N]; None where it was not.
        equilibria: displacement [mm] and force [N] of the reported end in the equilibria of all loading steps, in steps
            in real time in all states.
    """

    label: str
    run: RunData
    steps: dict[str, tuple[np.ndarray, np.ndarray]]
    displacement: np.ndarray
    force: np.ndarray
    spans: dict[str, tuple[float, float, float]]
    unbalanced: list[tuple[float, float]] = field(default_factory=list)
    band: float | None = None
    equilibria: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))

    def at(self, displacement: np.ndarray | float | str) -> np.ndarray:
        """Force at displacements within the curve [N]; where it jumps at one of them, before the jump.

        Args:
            displacement: [mm], of any shape, or a text such as "60 mm".

        Raises:
            InputError: the curve does not reach there.
        """
        wanted = np.asarray(displacement_of(displacement) if isinstance(displacement, str) else displacement)
        if not self.displacement.size:
            raise InputError("nothing was pulled", file=self.run.path, key="at", expected="a run with a pull")
        first, last = float(self.displacement[0]), float(self.displacement[-1])
        slack = 1e-6 * max(1.0, last)
        outside = (wanted < first - slack) | (wanted > last + slack) | np.isnan(wanted)
        if outside.any():
            found, expected = f"{float(wanted[outside].flat[0]):g} mm", f"{first:.4g} to {last:.4g} mm"
            raise InputError("outside the curve", file=self.run.path, key="at", found=found, expected=expected)
        first = np.minimum(np.searchsorted(self.displacement, wanted), self.displacement.size - 1)
        there = self.displacement[first] == wanted
        return np.where(there, self.force[first], np.interp(wanted, self.displacement, self.force))

    @property
    def drawn(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacement [mm] and force [N] of the pulls; without one, `equilibria`."""
        return (self.displacement, self.force) if self.displacement.size else self.equilibria

    def __repr__(self) -> str:
        reach = f"{self.displacement[0]:g} to {self.displacement[-1]:g} mm" if self.displacement.size else "no pull"
        return f"<force curve of {self.label!r}, {self.displacement.size} states, {reach}>"

    def plot(self, axes: Axes | None = None, **line: object) -> Axes:
        """Force [N] against displacement [mm], with a band of the error where it was measured.

        A figure of its own has the style of `kf.plot`, whose axes begin at 0.
        """
        from knotfem.plot.axes import axes_for
        from knotfem.plot.curves import DISPLACEMENT_LABELS, FORCE_LABELS, from_zero
        from knotfem.plot.fonts import literal

        with axes_for(axes) as drawn:
            (curve,) = drawn.plot(self.displacement, self.force, **{"label": literal(self.label), **line})  # pyright: ignore[reportArgumentType]
            if self.band is not None:
                low, high = self.force - self.band, self.force + self.band
                drawn.fill_between(self.displacement, low, high, color=curve.get_color(), alpha=0.25, lw=0)
            for first, last in self.unbalanced:
                drawn.axvspan(first, last, color="0.9", zorder=0)
            drawn.set(xlabel=DISPLACEMENT_LABELS["mm"], ylabel=FORCE_LABELS["N"])
            if axes is None:
                start, furthest = self.displacement.min(initial=np.inf), self.displacement.max(initial=0.0)
                from_zero(drawn, start, furthest, self.force.min(initial=0.0))
        return drawn

    def to_pandas(self) -> object:
        """A pandas DataFrame with the columns displacement_mm and force_N.

        Raises:
            MissingDependency: pandas is not installed.
        """
        return frame_of({"displacement_mm": self.displacement, "force_N": self.force})


def force_curve(run: RunData, label: str | None = None) -> ForceCurve:
    """Forces of a run, step by step, and against the displacement of all its pulls.

    Args:
        run: that has taken a loading step.
        label: for legends; None for the run's name.

    Raises:
        InputError: the run has taken no loading step yet.
    """
    table = run.table("force")
    if not table or not table["time_s"].size:
        raise InputError("no loading step is stored", file=run.path, expected="a run that knotfem pull has brought on")
    for column in ("time_s", "step", "displacement_mm", RUNNING, "force_N"):
        if column not in table:
            raise InputError("no such column", file=run.path, key=column, found=",".join(table))
    steps, spans, unbalanced = {}, {}, []
    displacement, force = [np.zeros(0)], [np.zeros(0)]
    held: list[np.ndarray] = [np.zeros(0, dtype=int)]
    for step in run.scene.loading_steps:
        rows = np.flatnonzero(table["step"] == step.name)
        if not rows.size:
            continue
        balanced = table["equilibrium"][rows] > 0 if "equilibrium" in table else np.ones(rows.size, dtype=bool)
        held.append(rows if step.real else rows[balanced])
        if not step.real and balanced.any():
            rows, balanced = rows[balanced], balanced[balanced]
        steps[step.name] = table["time_s"][rows], table["force_N"][rows]
        if isinstance(step, Pull):
            there, went = table["displacement_mm"][rows], table[RUNNING][rows]
            end = float(table["time_s"][rows][-1])
            displacement.append(there)
            force.append(table["force_N"][rows])
            unbalanced += stretches_of(~balanced, there)
            spans[step.name] = end - float(went[-1]) / step.nominal_speed, end, float(there[-1] - went[-1])
    name = run.name if label is None else label
    joined = np.concatenate(displacement), np.concatenate(force)
    every = np.concatenate(held)
    equilibria = table["displacement_mm"][every], table["force_N"][every]
    return ForceCurve(name, run, steps, *joined, spans, unbalanced, band_of(run), equilibria)


def band_of(run: RunData) -> float | None:
    """Root mean square error of a run's force curve [N] where it was measured with finer settings, else None."""
    return (run.summary.get("accuracy") or {}).get("band_N")


def force_at(run: RunData, moment: Moment) -> float:
    """Force at the reported end in a stored state [N]; 0 where no loading step is stored or before the first.

    Args:
        run: any.
        moment: of the state. At one time loads may stand still while rods settle, and a step may begin: the last row of
            the state's own step counts.
    """
    table = run.table("force")
    times, force = table.get("time_s", np.zeros(0)), table.get("force_N", np.zeros(0))
    own = table["step"] == moment.step if "step" in table else np.zeros(times.size, dtype=bool)
    if own.any():
        times, force = times[own], force[own]
    return float(np.interp(moment.time, times, force, left=0.0)) if times.size else 0.0


def unrest_notes(run: RunData) -> list[str]:
    """In words, for each pull in real time, where drag and inertia carried more than the scene's tolerance allows.

    Args:
        run: that has taken a loading step.
    """
    table, tolerance, notes = run.table("force"), run.scene.quasi_static.tolerance, []
    for step in run.scene.loading_steps:
        rows = np.flatnonzero(table["step"] == step.name) if table else np.zeros(0, dtype=int)
        if not isinstance(step, Pull) or not step.real or not rows.size:
            continue
        went, moving = table[RUNNING][rows], table["equilibrium"][rows] == 0
        far = sum(last - first for first, last in stretches_of(moving, went))
        if far == 0.0:
            continue
        share = table["unrest_N"][rows] / np.maximum(np.abs(table["force_N"][rows]), 1e-300)
        worst = int(np.argmax(np.where(moving, share, 0.0)))
        notes.append(
            f"{step.name} was not quasi-static: drag and inertia carried more than {tolerance:.2%} of the force over "
            f"{far:.3g} of {went[-1]:.4g} mm, {share[worst]:.1%} at {went[worst]:.4g} mm"
        )
    return notes


def tolerance_notes(run: RunData) -> list[str]:
    """In words, where the solver's tolerance does not promise the force of the last loading step to `PROMISED`.

    Args:
        run: that has taken a loading step.
    """
    table, tolerance = run.table("force"), run.scene.solver.force_tolerance
    if not table or not table["force_N"].size:
        return []
    step = table["step"][-1]
    largest = float(np.abs(table["force_N"][table["step"] == step]).max())
    error = ForceTolerance.of(tolerance).resultant
    if largest == 0.0 or error <= PROMISED * largest:
        return []
    promising = tolerance * PROMISED * largest / error
    return [
        f"solver.force_tolerance of {tolerance:g} N leaves the force of {step}, {largest:.3g} N at most, uncertain by "
        f"up to {error / largest:.2g} of it; {promising:.2g} N would promise {PROMISED:.0%}"
    ]


def stretches_of(marked: np.ndarray, displacement: np.ndarray) -> list[tuple[float, float]]:
    """Intervals of displacement [mm] that end in marked rows, each from the row before.

    Args:
        marked: boolean, shape [n].
        displacement: ascending [mm], shape [n].
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(np.int8), [0]])))
    return [(float(displacement[max(a - 1, 0)]), float(displacement[b - 1])) for a, b in edges.reshape(-1, 2)]


def onset_of_locking(displacement: np.ndarray, force: np.ndarray) -> float | None:
    """Displacement [mm] from which on the force rises `LOCKING_SLOPE` times faster than before, or None.

    Args:
        displacement: evenly spaced [mm], shape [n].
        force: [N], shape [n].
    """
    width = max(3, len(force) // 20)
    smooth = np.convolve(np.pad(force, width // 2, mode="edge"), np.full(width, 1.0 / width), mode="valid")[
        : len(force)
    ]
    slope = np.gradient(smooth, displacement)[width // 2 : -(width // 2)]
    limit = LOCKING_SLOPE * float(np.median(slope[: len(slope) // 2]))
    below = np.flatnonzero(slope < limit)
    if limit <= 0.0 or not below.size or below[-1] == len(slope) - 1:
        return None
    return float(displacement[width // 2 + below[-1] + 1])
