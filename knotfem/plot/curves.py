"""Force curves and tension profiles on given axes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.plot.fonts import literal
from knotfem.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

Table = Mapping[str, ArrayLike] | Sequence[Mapping[str, Any]]
DisplacementAxis = Literal["both", "radii", "mm"]

Lines = dict[str, list["Line2D"]]
"""Lines of each run on a panel, by its label."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINES = ("-", "--", ":", "-.")
FORCE_LABELS = {"N": r"force $F$ (N)", "B/r^2": r"force $F r^2 / B$"}
"""Of the vertical axis, by the unit of the force."""
LATE = 0.5
"""Curves that begin beyond this fraction of the largest displacement are drawn without what lies before."""
DISPLACEMENT_LABELS = {"mm": r"displacement $\delta$ (mm)", "radii": r"displacement $\delta / r$"}
"""Of the horizontal axis, by the unit of the displacement."""
TENSION_LABELS = {"N": r"tension $T$ (N)", "T/F": r"tension $T / F$"}
ARCLENGTH_LABELS = {"arclength_mm": r"arclength $s$ (mm)", "s_over_L": r"arclength $s / L$"}


def draw_force(
    axes: Axes,
    curves: Mapping[str, Table],
    radii: Mapping[str, float],
    *,
    axis: DisplacementAxis,
    bands: Mapping[str, float] | None = None,
    unbalanced: Sequence[tuple[float, float]] = (),
    named: bool = True,
) -> Lines:
    """Force against displacement of the pulled end.

    Args:
        axes: to draw on.
        curves: tables with the columns `displacement_mm` and `force_N`, by label.
        radii: of the rods [mm], by label.
        axis: displacement in radii, in mm, or in radii below and in mm above, where all radii are the same.
        bands: half the width [N] of a band around a curve, by its label.
        unbalanced: displacements [mm] between which the one curve is not of equilibria, shaded.
        named: whether there is a legend.
    """
    start, furthest, lowest = np.inf, 0.0, 0.0
    drawn: Lines = {}
    for (label, table), (colour, line) in zip(curves.items(), styles(curves), strict=True):
        unit = 1.0 if axis == "mm" else radii[label]
        displacement, force = column(table, "displacement_mm") / unit, column(table, "force_N")
        name = (literal(label) or None) if named else None
        drawn[label] = axes.plot(displacement, force, color=colour, ls=line, label=name)
        start, furthest = min([start, *displacement[:1]]), max([furthest, *displacement[-1:]])
        lowest = min([lowest, *force])
        for first, last in unbalanced if len(curves) == 1 else ():
            axes.axvspan(first / unit, last / unit, color="0.9", zorder=0, lw=0)
        width = (bands or {}).get(label)
        if width is not None:
            axes.fill_between(
                displacement, force - width, force + width, color=colour, alpha=0.25, lw=0,
                label=f"within {width:.2g} N",
            )  # fmt: skip
    axes.set(xlabel=DISPLACEMENT_LABELS["mm" if axis == "mm" else "radii"], ylabel=FORCE_LABELS["N"])
    from_zero(axes, start, furthest, lowest)
    if axis == "both" and curves:
        radius = next(iter(radii.values()))
        functions = (lambda x: np.multiply(x, radius), lambda x: np.divide(x, radius))
        axes.secondary_xaxis("top", functions=functions).set_xlabel(r"$\delta$ (mm)")
    legend(axes)
    return drawn


def draw_profiles(
    axes: Axes, profiles: Mapping[str, Mapping[str, Table]], *, named: bool, along: str = "s_over_L"
) -> Lines:
    """Tension profiles of all rods of all runs: a run has one colour, a rod one style of line.

    Args:
        axes: to draw on.
        profiles: tables with the columns `tension` and `along`, by label and rod.
        named: whether the legend names the runs; it names the rods where there are several.
        along: column of the horizontal axis, `s_over_L` or `arclength_mm`.
    """
    rods = dict.fromkeys(rod for tables in profiles.values() for rod in tables)
    lines = {rod: LINES[number % len(LINES)] for number, rod in enumerate(rods)}
    drawn: Lines = {label: [] for label in profiles}
    for (label, tables), (colour, _) in zip(profiles.items(), styles(profiles), strict=True):
        for rod, table in tables.items():
            drawn[label] += axes.plot(column(table, along), column(table, "tension"), color=colour, ls=lines[rod])
        if named:
            axes.plot([], [], color=colour, label=literal(label))
    for rod, line in lines.items() if len(lines) > 1 else ():
        axes.plot([], [], color="0.3", ls=line, label=literal(rod))
    axes.set_xlabel(ARCLENGTH_LABELS[along])
    axes.set_xlim(0.0, 1.0 if along == "s_over_L" else None)
    legend(axes)
    return drawn


def from_zero(axes: Axes, start: float, furthest: float, lowest: float) -> None:
    """Let axes begin at 0, or where the curves do if that is below or late.

    Args:
        axes: with curves on them.
        start: smallest displacement, infinite without one.
        furthest: largest displacement.
        lowest: smallest force.
    """
    late = np.isfinite(start) and start > LATE * furthest
    axes.set_xlim(left=start if late else min(start, 0.0))
    if lowest >= 0.0:
        axes.set_ylim(bottom=0.0)


def column(table: Table, name: str) -> Array:
    """Values of a column.

    Raises:
        InputError: there is none of this name.
    """
    try:
        values = table[name] if isinstance(table, Mapping) else [row[name] for row in table]
    except KeyError:
        has = table if isinstance(table, Mapping) else table[0]
        raise InputError("no such column in the table", key=name, found=", ".join(has)) from None
    return np.asarray(values, dtype=np.float64)


def styles(curves: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Colour and line of each curve; where colours are used up, they come again with another line."""
    colours = len(COLOURS)
    return [(COLOURS[i % colours], LINES[i // colours % len(LINES)]) for i in range(len(curves))]


def legend(axes: Axes, without: Collection[str] = ()) -> None:
    """A legend of what has a name, but for some runs; none where nothing has."""
    left_out = {literal(label) for label in without}
    named = [(handle, name) for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
             if name not in left_out]  # fmt: skip
    if named:
        axes.legend(*zip(*named, strict=True))
    elif (old := axes.get_legend()) is not None:
        old.remove()


def out_of_view(axes: Axes, drawn: Lines) -> list[str]:
    """Labels of the runs of which no line crosses the part of the plane that is shown."""
    return [
        label
        for label, lines in drawn.items()
        if not any(line.get_path().intersects_bbox(axes.viewLim, filled=False) for line in lines)
    ]
