"""Figures of one or several runs: force against displacement, tension along the rods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from knotfem.errors import InputError
from knotfem.plot.curves import (
    FORCE_LABELS,
    TENSION_LABELS,
    DisplacementAxis,
    Lines,
    draw_force,
    draw_profiles,
    legend,
    out_of_view,
)
from knotfem.plot.fonts import literal
from knotfem.plot.paper import COLUMN, Sheet, check_format, drawing, panels_of, write
from knotfem.results.base import displacement_of, labels_of
from knotfem.results.data import open_run
from knotfem.results.force import force_at, force_curve
from knotfem.results.moment import moment_heading
from knotfem.results.profile import TensionProfile
from knotfem.results.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Quantity = Literal["force", "tension", "both"]
Limits = tuple[float | None, float | None]
"""Smallest and largest value on an axis; None leaves it to the data."""
SLENDERNESS = 0.78
"""Height of a panel over its width."""
SIZES = {"width": (20.0, 1000.0), "height": (20.0, 1000.0), "font": (3.0, 40.0)}
"""Of figures: width and height [mm], size of letters [pt]."""


@dataclass(frozen=True)
class Drawn:
    """A figure and what it shows.

    Attributes:
        figure: of matplotlib.
        labels: of the runs.
        profiles: the tension profiles that are drawn, one a run; none where only forces are.
        out_of_view: labels of the runs that have nothing between the limits; the legend leaves them out.
    """

    figure: Figure
    labels: list[str]
    profiles: list[TensionProfile]
    out_of_view: list[str]


def plot(
    *runs: Run | str | Path,
    out: str | Path | None = None,
    quantity: Quantity = "force",
    width: float | str | None = None,
    height: float | str | None = None,
    font: float = 9.0,
    axis: DisplacementAxis | None = None,
    force_unit: Literal["N", "B/r^2"] = "N",
    labels: Sequence[str] = (),
    xlim: Limits = (None, None),
    ylim: Limits = (None, None),
    at: float | str | None = None,
    step: str | None = None,
    title: str | None = None,
) -> Drawn:
    """Draw force against displacement, tension along the centreline, or both side by side.

    Runs may have ended before their goal: what they have stored is drawn.

    Args:
        runs: one or more, of any model, or their run directories.
        out: file to write (.pdf, .svg, .png); None writes none.
        quantity: "force", "tension" or "both".
        width: of the figure, [mm] or such as "85 mm"; 91 mm a panel by default.
        height: likewise; in proportion to the width by default.
        font: size of letters [pt].
        axis: "radii" draws displacements over the radius of each run's thinnest rod, "mm" displacements and arclengths
            in mm, "both" radii below and mm above; None is "both" where all radii are the same, else "radii".
        force_unit: "N", or "B/r^2" of each run's softest rod.
        labels: of the runs in the legend; their names by default, and no legend for a single run.
        xlim: of the horizontal axis as it is drawn, some of the data between them; not with both quantities.
        ylim: likewise, of the vertical axis.
        at: displacement of the tension profiles over all steps, [mm] or such as "60 mm"; the nearest stored state of
            each run is taken; None for the last.
        step: name of the step that these states are to be of; None for any.
        title: heading; figures of tension say below it which states they show.

    Raises:
        InputError: no runs, one that has stored nothing to draw, or arguments that do not fit.
        MissingDependency: matplotlib is absent.
    """
    _check(quantity, axis, force_unit, (*xlim, *ylim))
    if not runs:
        raise InputError("nothing to draw", expected="a run")
    if labels and len(labels) != len(runs):
        found, expected = f"{len(labels)} for {len(runs)} runs", "one for each run, in their order"
        raise InputError("labels do not fit the runs", key="label", found=found, expected=expected)
    if labels and len(set(labels)) < len(labels):
        raise InputError("two runs have the same label", key="label", found=", ".join(labels))
    if out is not None:
        check_format(Path(out))
    opened = [run if isinstance(run, Run) else open_run(run) for run in runs]
    names = list(labels) or labels_of(opened)
    panels = 2 if quantity == "both" else 1
    sheet = _sheet(width, height, font, panels)
    named = bool(labels) or len(opened) > 1
    millimetres = displacement_of(at)
    with drawing(sheet) as figure:
        axes = panels_of(figure, panels)
        profiles: list[TensionProfile] = []
        hidden: list[str] = []
        lines: Lines = {}
        if quantity != "tension":
            lines = _draw_forces(axes[0], dict(zip(names, opened, strict=True)), axis, force_unit, named)
        if quantity != "force":
            profiles = [run.tension(millimetres, step) for run in opened]
            drawn = dict(zip(names, zip(opened, profiles, strict=True), strict=True))
            profile_lines = _draw_tensions(axes[-1], drawn, axis, named and quantity == "tension")
            lines = lines or profile_lines
            axes[-1].set_title(_heading(drawn), fontsize=font)
        for side, (low, high) in (("x", xlim), ("y", ylim)):
            if low is not None or high is not None:
                _check_limits(axes[0], side, low, high)
                (axes[0].set_xlim if side == "x" else axes[0].set_ylim)(low, high)
                hidden = out_of_view(axes[0], lines)
        if hidden:
            legend(axes[0], without=hidden)
        if title:
            below = f"\n{axes[0].get_title()}" if axes[0].get_title() else ""
            axes[0].set_title(literal(title) + below, fontsize=font + 1.0)
        if out is not None:
            write(figure, Path(out))
    return Drawn(figure, names, profiles, hidden)


def _draw_forces(
    axes: Axes, runs: Mapping[str, Run], axis: DisplacementAxis | None, force_unit: str, named: bool
) -> Lines:
    radii = {label: 0.5 * run.scene.diameter for label, run in runs.items()}
    same = len(set(radii.values())) == 1
    if axis == "both" and not same:
        found = ", ".join(f"{label} {radius:g} mm" for label, radius in radii.items())
        raise InputError(
            "rods of different radii have no axis in common", key="axis", found=found, expected="radii, mm"
        )
    curves = {label: force_curve(run, label) for label, run in runs.items()}
    scales = {label: 1.0 if force_unit == "N" else run.scene.force_scale for label, run in runs.items()}
    tables = {}
    for label, curve in curves.items():
        displacement, force = curve.drawn
        tables[label] = {"displacement_mm": displacement, "force_N": force / scales[label]}
    bands = {label: curve.band / scales[label] for label, curve in curves.items() if curve.band is not None}
    unbalanced = next(iter(curves.values())).unbalanced
    chosen = axis or ("both" if same else "radii")
    lines = draw_force(axes, tables, radii, axis=chosen, bands=bands, unbalanced=unbalanced, named=named)
    axes.set_ylabel(FORCE_LABELS[force_unit])
    return lines


def _draw_tensions(
    axes: Axes, runs: Mapping[str, tuple[Run, TensionProfile]], axis: DisplacementAxis | None, named: bool
) -> Lines:
    forces = {label: force_at(run, profile.moment) for label, (run, profile) in runs.items()}
    over_force = all(force > 0.0 for force in forces.values())
    along = "arclength_mm" if axis == "mm" else "s_over_L"
    tables = {}
    for label, (_, profile) in runs.items():
        scale = forces[label] if over_force else 1.0
        parts = {rod: profile.of(rod) for rod in profile.rods}
        tables[label] = {
            rod: {along: part.table[along], "tension": part.tension / scale} for rod, part in parts.items()
        }
    lines = draw_profiles(axes, tables, named=named, along=along)
    axes.set_ylabel(TENSION_LABELS["T/F" if over_force else "N"])
    return lines


def _heading(runs: Mapping[str, tuple[Run, TensionProfile]]) -> str:
    """Which states the profiles are of."""
    moments = {label: moment_heading(profile.moment) for label, (_, profile) in runs.items()}
    if len(set(moments.values())) == 1:
        return next(iter(moments.values()))
    return "\n".join(f"{literal(label)}: {said}" for label, said in moments.items())


def _check(quantity: str, axis: str | None, force_unit: str, limits: Sequence[float | None]) -> None:
    for key, value, known in (
        ("quantity", quantity, get_args(Quantity)),
        ("axis", axis, (None, *get_args(DisplacementAxis))),
        ("force_unit", force_unit, tuple(FORCE_LABELS)),
    ):
        if value not in known:
            expected = ", ".join(str(one) for one in known if one)
            raise InputError("unknown choice", key=key, found=f'"{value}"', expected=expected)
    if quantity == "both" and any(limit is not None for limit in limits):
        raise InputError("limits of two panels", key="xlim, ylim", expected='a figure each: "force" and "tension"')
    for key, (low, high) in {"xlim": limits[:2], "ylim": limits[2:]}.items():
        if low is not None and high is not None and not low < high:
            raise InputError("limits that do not rise", key=key, found=f"{low:g}:{high:g}", expected="low below high")


def _check_limits(axes: Axes, side: str, low: float | None, high: float | None) -> None:
    """Refuse limits of an axis between which no curve has a point.

    Raises:
        InputError: there is none.
    """
    curves = [line.get_xdata() if side == "x" else line.get_ydata() for line in axes.get_lines()]
    values = np.concatenate([np.asarray(curve, dtype=np.float64) for curve in curves])
    values = values[np.isfinite(values)]
    if not values.size:
        return
    first, last = float(values.min()), float(values.max())
    if (low is not None and low > last) or (high is not None and high < first):
        found = ":".join("" if limit is None else f"{limit:g}" for limit in (low, high))
        expected = f"limits within which there is something: the data go from {first:.4g} to {last:.4g}"
        raise InputError("nothing lies between these limits", key=f"{side}lim", found=found, expected=expected)


def _sheet(width: float | str | None, height: float | str | None, font: float, panels: int) -> Sheet:
    across = panels * COLUMN if width is None else displacement_of(width, "width") or 0.0
    sizes = dict(SIZES)
    if height is None:  # it follows from the width, whose bounds then are those of both
        high, slope = SLENDERNESS * across / panels, SLENDERNESS / panels
        (low, most), (shortest, tallest) = SIZES["width"], SIZES["height"]
        sizes["width"] = max(low, shortest / slope), min(most, tallest / slope)
    else:
        high = displacement_of(height, "height") or 0.0
    for key, value in (("width", across), ("height", high), ("font", font)):
        low, most = sizes[key]
        if not low * (1.0 - 1e-9) <= value <= most * (1.0 + 1e-9) or not np.isfinite(value):
            unit = "pt" if key == "font" else "mm"
            expected = f"{low:.3g} to {most:.4g} {unit}"
            if key == "width" and height is None:
                expected += " without a height of its own"
            raise InputError("no size of a figure", key=key, found=f"{value:g} {unit}", expected=expected)
    return Sheet(across, high, font, dpi=300.0)
