"""Runs side by side: force against displacement, tension along the rod, size of the knot, cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.results.base import labels_of
from knotfem.results.data import open_run
from knotfem.results.force import ForceCurve, force_curve, onset_of_locking
from knotfem.results.profiles import CommonState, Profiles, common_state, knot_length, profiles_apart, relative_l2
from knotfem.results.run import Run
from knotfem.run.tables import write_table

POINTS = 400
"""Displacements at which curves are compared."""
Cell = float | str | None
RELATIVE = "share"
"""Unit, in tables, of a difference relative to the first run."""


@dataclass(frozen=True)
class Figure:
    """One thing that is compared.

    Attributes:
        name: what.
        unit: "mm", "N", "s", `RELATIVE` or "".
        cells: one a run.
        short: name where room is short; "" for the same.
    """

    name: str
    unit: str
    cells: Sequence[Cell]
    short: str = ""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several runs, the first of which the others are held against.

    Attributes:
        curves: of all runs.
        figures: what is compared.
        locking: displacement at which the first run begins to lock [mm], or None.
        state: in which tension along the rods is compared, or None.
    """

    curves: list[ForceCurve]
    figures: list[Figure]
    locking: float | None
    state: CommonState | None

    def __repr__(self) -> str:
        return f"<comparison of {', '.join(curve.label for curve in self.curves)}>"

    def write(self, out: str | Path) -> Path:
        """Draw the picture, and write the figures into a CSV table beside it, whose file is returned.

        Raises:
            InputError: one of them cannot be written.
        """
        out = Path(out)
        self._draw(out)
        table = out.with_suffix(".csv")
        columns = {"figure": [f.name for f in self.figures], "unit": [f.unit for f in self.figures]}
        columns |= {c.label: [_text(f.cells[i]) for f in self.figures] for i, c in enumerate(self.curves)}
        write_table(table, {name: np.array(column) for name, column in columns.items()})
        return table

    def _draw(self, out: Path) -> None:
        from knotfem.plot.plots import plot_comparison

        pulled = self.curves if all(c.displacement.size for c in self.curves) else []
        forces = {c.label: {"displacement_mm": c.displacement, "force_N": c.force} for c in pulled}
        profiles: dict[str, Profiles] = {}
        told: dict[str, Any] = {}
        if self.state is not None:
            at, labels = self.state.displacements, [curve.label for curve in self.curves]
            profiles = dict(zip(labels, self.state.profiles, strict=True))
            told = {"over_force": self.state.over_force, "at": at, "step": self.state.step}
        radii = {c.label: 0.5 * c.run.scene.diameter for c in self.curves}
        plot_comparison(forces, profiles, out, radii=radii, locking=self.locking, **told)


def compare(
    *runs: Run | str | Path, locking: float | None = None, at: float | None = None, step: str | None = None
) -> Comparison:
    """Hold runs against the first of them.

    Args:
        runs: two or more, of any model, or their run directories.
        locking: displacement at which the knot begins to lock [mm]; None finds where the first run's force does.
        at: displacement of the tension profiles [mm], or None.
        step: name of the step at whose end the tension profiles are taken, or None; with neither of both, the last
            that all runs have stored.

    Raises:
        InputError: the same run twice, a run without a loading step, runs that have neither pulls nor a step in
            common, pulls without a displacement in common, or no such state.
    """
    if len(runs) < 2:
        expected = "two or more; knotfem plot draws a single one"
        raise InputError("nothing to compare", found=f"{len(runs)} run{'s' * (not runs)}", expected=expected)
    opened = [run if isinstance(run, Run) else open_run(run) for run in runs]
    curves = [force_curve(run, label) for run, label in zip(opened, labels_of(opened), strict=True)]
    figures, onset = _records(opened, curves), None
    pulled = all(curve.displacement.size for curve in curves)
    if pulled:
        forces, onset = _forces(curves, locking)
        figures += forces
    state = common_state(curves, at, step)
    if state is not None:
        figures += _tensions(curves, state)
    elif not pulled:
        found = "; ".join(f"{curve.label} {', '.join(curve.steps)}" for curve in curves)
        raise InputError("the runs have no stored step in common", found=found, expected="pulls, or steps of one name")
    return Comparison(curves, figures, onset, state)


def _forces(curves: Sequence[ForceCurve], locking: float | None) -> tuple[list[Figure], float | None]:
    """Force curves over the displacements that all have, and where the first run begins to lock [mm]."""
    low, high = _common_displacements(curves)
    if locking is not None and not low < locking < high:
        problem = "the runs have no such displacement in common"
        expected = f"between {low:.4g} and {high:.4g} mm"
        raise InputError(problem, key="--locking", found=f"{locking:g} mm", expected=expected)
    first, *others = curves
    grid = np.linspace(low, high, POINTS)
    onsets = [onset_of_locking(grid, curve.at(grid)) for curve in curves]
    onset = onsets[0] if locking is None else locking
    loose = grid <= (np.inf if onset is None else onset)
    ends = [float(curve.at(high)) for curve in curves]

    def difference(name: str, part: np.ndarray, short: str) -> Figure:
        cells = [None, *(relative_l2(curve.at(part), first.at(part)) for curve in others)]
        return Figure(f"{name}, L2 difference", RELATIVE, cells, short)

    figures = [
        Figure("compared from", "mm", [low] * len(curves), "from"),
        Figure("compared to", "mm", [high] * len(curves), "to"),
        Figure("force there", "N", ends, "F there"),
        Figure("force there, difference", RELATIVE, _relative(ends), "F diff."),
        Figure("begins to lock at", "mm", onsets, "locks at"),
        difference("force curve", grid, "L2 F"),
        difference("force curve before locking", grid[loose], "L2 before"),
        difference("force curve after locking", grid[~loose], "L2 after"),
    ]
    return figures, onset


def _common_displacements(curves: Sequence[ForceCurve]) -> tuple[float, float]:
    """The displacements that all curves have, from and to [mm].

    Raises:
        InputError: there are none.
    """
    low, high = max(c.displacement[0] for c in curves), min(c.displacement[-1] for c in curves)
    if low >= high:
        spans = "; ".join(f"{c.label} {c.displacement[0]:.4g} to {c.displacement[-1]:.4g} mm" for c in curves)
        raise InputError("the runs have no displacement in common", found=spans, expected="pulls that overlap")
    return low, high


def _tensions(curves: Sequence[ForceCurve], state: CommonState) -> list[Figure]:
    """Tension profiles and the size of the knot in one state."""
    if state.displacements is not None:
        where = Figure("tension profile at", "mm", state.displacements, "T at")
    else:
        where = Figure("tension profile at the end of", "", [state.step] * len(curves), "T at end of")
    first, *others = state.profiles
    sizes = [knot_length(c, p) for c, p in zip(curves, state.profiles, strict=True)]
    unit = "T/F" if state.over_force else "T"
    apart: list[Cell] = [None, *(profiles_apart(p, first) for p in others)]
    return [
        where,
        Figure("force F there", "N", state.forces, "F there"),
        Figure(f"tension {unit}, L2 difference", RELATIVE, apart, f"L2 {unit}"),
        Figure("knot length", "mm", sizes, "knot"),
        Figure("knot length, difference", RELATIVE, _relative(sizes), "knot diff."),
    ]


def _records(runs: Sequence[Run], curves: Sequence[ForceCurve]) -> list[Figure]:
    """What the runs are, and what they took."""
    summaries = [run.summary for run in runs]
    reached = [float(c.displacement[-1]) if c.displacement.size else None for c in curves]

    def recorded(name: str, key: str, short: str = "") -> Figure:
        return Figure(name, "", [summary.get(key) for summary in summaries], short)

    return [
        Figure("model", "", [run.scene.model for run in runs]),
        recorded("unknowns", "dofs"),
        recorded("steps", "steps"),
        Figure("wall", "s", [run.cost.wall_s for run in runs]),
        Figure("CPU", "s", [run.cost.cpu_s for run in runs]),
        Figure("knot", "", [_knot_name(run.knot) for run in runs]),
        recorded("largest penetration over d", "max_penetration_over_d", "depth/d"),
        Figure("pulled to", "mm", reached, "pulled"),
    ]


def _knot_name(knot: str | dict[str, str] | None) -> str | None:
    return "; ".join(knot.values()) if isinstance(knot, dict) else knot


def _relative(values: Sequence[float | None]) -> list[Cell]:
    """Differences relative to the first value; None for that, and where there is no value or the first is nothing."""
    first, *others = values
    return [None, *(value / first - 1.0 if value is not None and first else None for value in others)]


def _text(cell: Cell) -> str:
    return "" if cell is None else f"{cell:.6g}" if isinstance(cell, float) else str(cell)
