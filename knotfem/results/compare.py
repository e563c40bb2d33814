"""Runs side by side: force against displacement, tension along the rod, size of the knot, cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.errors import InputError
from knotfem.results.data import open_run
from knotfem.results.force import ForceCurve, force_curve, onset_of_locking
from knotfem.results.profiles import CommonState, common_state, knot_length, profiles_apart, relative_l2
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
    """

    name: str
    unit: str
    cells: Sequence[Cell]


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

    def write(self, out: Path) -> Path:
        """Draw the picture, and write the figures into a CSV table beside it, whose file is returned.

        Raises:
            InputError: one of them cannot be written.
        """
        from knotfem.plot.plots import plot_comparison

        labels = [curve.label for curve in self.curves]
        pulled = self.curves if all(c.displacement.size for c in self.curves) else []
        forces = {c.label: {"displacement_mm": c.displacement, "force_N": c.force} for c in pulled}
        state = self.state
        profiles = {} if state is None else dict(zip(labels, state.profiles, strict=True))
        radius = 0.5 * self.curves[0].run.scene.diameter
        plot_comparison(
            forces,
            profiles,
            out,
            radius=radius,
            locking=self.locking,
            over_force=state is not None and state.over_force,
            at=None if state is None or state.displacements is None else state.displacements[0],
            step=None if state is None else state.step,
        )
        table = out.with_suffix(".csv")
        columns = {"figure": [f.name for f in self.figures], "unit": [f.unit for f in self.figures]}
        columns |= {label: [_text(f.cells[i]) for f in self.figures] for i, label in enumerate(labels)}
        write_table(table, {name: np.array(column) for name, column in columns.items()})
        return table


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
        InputError: a run without a loading step, runs that have neither pulls nor a step in common, pulls without a
            displacement in common, or no such state.
    """
    if len(runs) < 2:
        raise InputError("nothing to compare", found=f"{len(runs)} run", expected="two or more")
    opened = [run if isinstance(run, Run) else open_run(run) for run in runs]
    curves = [force_curve(run, label) for run, label in zip(opened, _labels(opened), strict=True)]
    figures, onset = _records(curves), None
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
    first, *others = curves
    low, high = max(c.displacement[0] for c in curves), min(c.displacement[-1] for c in curves)
    if low >= high:
        spans = "; ".join(f"{c.label} {c.displacement[0]:.4g} to {c.displacement[-1]:.4g} mm" for c in curves)
        raise InputError("the runs have no displacement in common", found=spans, expected="pulls that overlap")
    if locking is not None and not low < locking < high:
        problem = "the runs have no such displacement in common"
        expected = f"between {low:.4g} and {high:.4g} mm"
        raise InputError(problem, key="--locking", found=f"{locking:g} mm", expected=expected)
    grid = np.linspace(low, high, POINTS)
    onset = onset_of_locking(grid, first.at(grid)) if locking is None else locking
    loose = grid <= (np.inf if onset is None else onset)
    ends = [float(c.at(high)) for c in curves]
    figures = [
        Figure("compared from", "mm", [low] * len(curves)),
        Figure("compared to", "mm", [high] * len(curves)),
        Figure("force there", "N", ends),
        Figure("force there, difference", RELATIVE, [None, *(_relative(end, ends[0]) for end in ends[1:])]),
        Figure("begins to lock at", "mm", [onset_of_locking(grid, c.at(grid)) for c in curves]),
        Figure(
            "force curve, L2 difference", RELATIVE, [None, *(relative_l2(c.at(grid), first.at(grid)) for c in others)]
        ),
    ]
    for name, part in (("before", grid[loose]), ("after", grid[~loose])):
        cells = [None, *(relative_l2(c.at(part), first.at(part)) for c in others)]
        figures.append(Figure(f"force curve {name} locking, L2 difference", RELATIVE, cells))
    return figures, onset


def _tensions(curves: Sequence[ForceCurve], state: CommonState) -> list[Figure]:
    """Tension profiles and the size of the knot in one state."""
    if state.displacements is not None:
        where = Figure("tension profile at", "mm", state.displacements)
    else:
        where = Figure("tension profile at the end of", "", [state.step] * len(curves))
    first, *others = state.profiles
    sizes = [knot_length(c, p) for c, p in zip(curves, state.profiles, strict=True)]
    unit = "T/F" if state.over_force else "T"
    return [
        where,
        Figure("force F there", "N", state.forces),
        Figure(f"tension {unit}, L2 difference", RELATIVE, [None, *(profiles_apart(p, first) for p in others)]),
        Figure("knot length", "mm", sizes),
        Figure("knot length, difference", RELATIVE, [None, *(_relative(size, sizes[0]) for size in sizes[1:])]),
    ]


def _labels(runs: Sequence[Run]) -> list[str]:
    names = [run.name for run in runs]
    numbered = [f"{name} ({number})" for number, name in enumerate(names, 1)]
    long = [other if run.path is None else str(run.path) for run, other in zip(runs, numbered, strict=True)]
    return [name if names.count(name) == 1 else other for name, other in zip(names, long, strict=True)]


def _records(curves: Sequence[ForceCurve]) -> list[Figure]:
    summaries: list[dict[str, Any]] = [curve.run.summary for curve in curves]
    phases = [summary.get("phases", {}).values() for summary in summaries]
    knots = [summary.get("knot_after") for summary in summaries]
    named = [", ".join(k["name"] for k in knot.values()) if isinstance(knot, dict) else knot for knot in knots]
    return [
        Figure("model", "", [curve.run.scene.model for curve in curves]),
        Figure("unknowns", "", [summary.get("dofs") for summary in summaries]),
        Figure("steps", "", [summary.get("steps") for summary in summaries]),
        Figure("wall", "s", [sum(phase["wall_s"] for phase in all_of) for all_of in phases]),
        Figure("CPU", "s", [sum(phase["cpu_s"] for phase in all_of) for all_of in phases]),
        Figure("knot", "", named),
        Figure("largest penetration over d", "", [summary.get("max_penetration_over_d") for summary in summaries]),
        Figure("pulled to", "mm", [float(c.displacement[-1]) if c.displacement.size else None for c in curves]),
    ]


def _relative(value: float | None, first: float | None) -> float | None:
    return value / first - 1.0 if value is not None and first else None


def _text(cell: Cell) -> str:
    return "" if cell is None else f"{cell:.6g}" if isinstance(cell, float) else str(cell)
