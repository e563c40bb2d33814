"""Curves of a run on paper: force, tension, stretch while tying (matplotlib, no display needed)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError, MissingDependency
from knotfem.files import write_atomically
from knotfem.plot.fonts import literal, use_fonts_for, without_glyph_warnings
from knotfem.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Table = Mapping[str, ArrayLike] | Sequence[Mapping[str, Any]]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINES = ("-", "--", ":", "-.")
SUFFIXES = (".png", ".pdf", ".svg")
_STYLE: Any = {
    "font.size": 9,
    "axes.labelsize": 10,
    "axes.linewidth": 0.8,
    "axes.xmargin": 0.0,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "ytick.right": True,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "savefig.dpi": 200,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def plot_force(
    curves: Mapping[str, Table],
    out: str | Path,
    *,
    radius: float,
    title: str | None = None,
    bands: Mapping[str, float] | None = None,
) -> None:
    """Draw force against displacement of the pulled end.

    Args:
        curves: tables with the columns `displacement_mm` and `force_N` (of force.csv), by label.
        out: file to write (.png, .pdf, .svg).
        radius: radius of the rod in mm; displacement is drawn in radii below and in mm above.
        title: heading.
        bands: half the width [N] of a band around a curve, by its label.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    with paper_axes(out, title) as axes:
        _draw_force(axes, curves, radius, bands)


def plot_comparison(
    forces: Mapping[str, Table],
    profiles: Mapping[str, Mapping[str, Table]],
    out: str | Path,
    *,
    radius: float,
    locking: float | None = None,
    over_force: bool = True,
    at: Sequence[float] | None = None,
    step: str | None = None,
) -> None:
    """Draw the force curves of several runs over each other, and beside them their tension profiles.

    A run has one colour, a rod one style of line.

    Args:
        forces: tables with the columns `displacement_mm` and `force_N`, by label; none draws no force curves.
        profiles: tables with the columns `s_over_L` and `tension`, by label and rod; none draws no profiles.
        out: file to write (.png, .pdf, .svg).
        radius: radius of the rod in mm.
        locking: displacement in mm at which the knot begins to lock, drawn dashed.
        over_force: whether tension is T/F instead of T in N.
        at: displacement in mm of each run's profile.
        step: at whose end the profiles are.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    with _paper_panels(out, None, bool(forces) + bool(profiles), width=3.6) as panels:
        if forces:
            _draw_force(panels[0], forces, radius)
            if locking is not None:
                panels[0].axvline(locking / radius, color="0.5", lw=0.8, ls="--", label="begins to lock")
                _legend(panels[0])
        if profiles:
            _draw_profiles(panels[-1], profiles, named=not forces)
            panels[-1].set_ylabel(r"tension $T / F$" if over_force else r"tension $T$ (N)")
            places = ", ".join(dict.fromkeys(f"{place:.4g}" for place in at or ()))
            heading = rf"$\delta = {places}$ mm" if places else f"end of {step}" if step else ""
            panels[-1].set_title(heading, fontsize=9)


def plot_tension(
    curves: Mapping[str, Table],
    out: str | Path,
    *,
    applied: float,
    levels: Sequence[float] = (),
    drops: Sequence[tuple[float, float]] = (),
    title: str | None = None,
) -> None:
    """Draw the tension along the centreline.

    One table is drawn in all its parts: nodal forces across each section, the integral of stresses, and core and bulk
    apart. Several are drawn by their nodal forces.

    Args:
        curves: tables with the columns `s_over_L`, `tension_N`, `core_N` and `bulk_N` (of tension.csv), by label.
        out: file to write (.png, .pdf, .svg).
        applied: force T0 at the loading end in N, the unit of the vertical axis.
        levels: expected levels of T/T0, drawn dashed (plateau, tail load).
        drops: intervals of s/L in which a drop is expected, shaded.
        title: heading.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    with paper_axes(out, title) as axes:
        for start, end in drops:
            axes.axvspan(start, end, color="0.93", lw=0)
        for level in levels:
            axes.axhline(level, color="0.5", lw=0.8, ls="--")
        for colour, (label, table) in zip(_colours(curves), curves.items(), strict=True):
            s, tension = _column(table, "s_over_L"), _column(table, "tension_N") / applied
            axes.plot(s, tension, color=colour, label=literal(label) or "nodal forces", zorder=3)
            if len(curves) == 1:
                core, bulk = _column(table, "core_N") / applied, _column(table, "bulk_N") / applied
                every = max(1, len(s) // 60)
                style: dict[str, Any] = {"ls": "none", "marker": "o", "ms": 3.2, "mfc": "none", "mew": 0.8, "zorder": 4}
                axes.plot(s[::every], (core + bulk)[::every], color="k", label="stresses", **style)
                axes.plot(s, core, color=COLOURS[1], lw=0.9, label="core")
                axes.plot(s, bulk, color=COLOURS[2], lw=0.9, label="bulk")
        axes.set(xlabel=r"arclength $s / L$", ylabel=r"tension $T / T_0$", xlim=(0, 1))
        _legend(axes)


def plot_stretch(
    arclength: Array,
    stretch_by_time: Array,
    times: Array,
    out: str | Path,
    *,
    threshold: float | None = None,
    title: str | None = None,
) -> None:
    """Draw the centreline stretch against arclength, coloured by mapping time (figure 2b of the paper).

    Args:
        arclength: s/L of each stretch, from 0 to 1, shape (n,).
        stretch_by_time: stretch lambda, shape (times, n).
        times: mapping times, from 0 to 1, shape (times,).
        out: file to write (.png, .pdf, .svg).
        threshold: bound on |lambda - 1|, drawn dashed.
        title: heading.

    Raises:
        InputError: the format is unknown or the file cannot be written.
        ValueError: the shapes do not agree.
    """
    shape = (len(times), len(arclength))
    if np.shape(stretch_by_time) != shape:
        raise ValueError(f"stretch has shape {np.shape(stretch_by_time)}, expected {shape}")
    with paper_axes(out, title, width=4.2) as axes:
        from matplotlib.collections import LineCollection

        lines = [np.column_stack([arclength, stretch]) for stretch in stretch_by_time]
        drawn = LineCollection(lines, array=np.asarray(times), cmap="viridis", linewidths=0.9)
        drawn.set_clim(0.0, 1.0)
        axes.add_collection(drawn)
        axes.autoscale_view()
        if threshold is not None:
            for level in (1 - threshold, 1 + threshold):
                axes.axhline(level, color="0.4", lw=0.8, ls="--")
        figure = axes.get_figure()
        assert figure is not None
        figure.colorbar(drawn, ax=axes, label=r"mapping time $t^m$", pad=0.02)
        axes.set(xlabel=r"arclength $\tilde{s} = s / L$", ylabel=r"stretch $\lambda$", xlim=(0, 1))


def _draw_profiles(axes: Axes, profiles: Mapping[str, Mapping[str, Table]], *, named: bool) -> None:
    """Profiles of all rods of all runs; a legend of the runs where `named`, of the rods where there are several."""
    rods = dict.fromkeys(rod for tables in profiles.values() for rod in tables)
    lines = {rod: LINES[number % len(LINES)] for number, rod in enumerate(rods)}
    for colour, (label, tables) in zip(_colours(profiles), profiles.items(), strict=True):
        for rod, table in tables.items():
            axes.plot(_column(table, "s_over_L"), _column(table, "tension"), color=colour, ls=lines[rod])
        if named:
            axes.plot([], [], color=colour, label=literal(label))
    for rod, line in lines.items() if len(lines) > 1 else ():
        axes.plot([], [], color="0.3", ls=line, label=literal(rod))
    axes.set(xlabel=r"arclength $s / L$", xlim=(0, 1))
    _legend(axes)


def _draw_force(
    axes: Axes, curves: Mapping[str, Table], radius: float, bands: Mapping[str, float] | None = None
) -> None:
    for colour, (label, table) in zip(_colours(curves), curves.items(), strict=True):
        displacement, force = _column(table, "displacement_mm"), _column(table, "force_N")
        axes.plot(displacement / radius, force, color=colour, label=literal(label) or None)
        width = (bands or {}).get(label)
        if width is not None:
            axes.fill_between(
                displacement / radius, force - width, force + width, color=colour, alpha=0.25, lw=0,
                label=f"within {width:.2g} N",
            )  # fmt: skip
    axes.set(xlabel=r"displacement $\delta / r$", ylabel=r"force $F$ (N)")
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    above = axes.secondary_xaxis("top", functions=(lambda x: np.multiply(x, radius), lambda x: np.divide(x, radius)))
    above.set_xlabel(r"$\delta$ (mm)")
    _legend(axes)


@contextmanager
def paper_axes(out: str | Path, title: str | None, *, width: float = 3.6) -> Iterator[Axes]:
    """Axes of a one-column figure, which is then written as a whole."""
    with _paper_panels(out, title, 1, width=width) as panels:
        yield panels[0]


@contextmanager
def _paper_panels(out: str | Path, title: str | None, count: int, *, width: float) -> Iterator[list[Axes]]:
    """Axes side by side, each of a width, of a figure that is then written as a whole."""
    out = Path(out)
    if out.suffix.lower() not in SUFFIXES:
        raise InputError(
            "no such picture format", file=out, found=out.suffix or "no suffix", expected=", ".join(SUFFIXES)
        )
    try:
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingDependency(f"plots need matplotlib ({error}): pip install matplotlib") from error

    with rc_context(_STYLE):
        figure = Figure(figsize=(count * width, 2.8), layout="constrained")
        FigureCanvasAgg(figure)
        panels = [figure.add_subplot(1, count, number + 1) for number in range(count)]
        for axes in panels:
            axes.grid(True, lw=0.4, color="0.9")
            axes.set_axisbelow(True)
        yield panels
        if title:
            panels[0].set_title(title, fontsize=10)
        picture = BytesIO()
        use_fonts_for(figure)
        with without_glyph_warnings():
            figure.savefig(picture, format=out.suffix[1:].lower())
        write_atomically(out, picture.getvalue())


def _column(table: Table, name: str) -> Array:
    try:
        values = table[name] if isinstance(table, Mapping) else [row[name] for row in table]
    except KeyError:
        has = table if isinstance(table, Mapping) else table[0]
        raise InputError("no such column in the table", key=name, found=", ".join(has)) from None
    return np.asarray(values, dtype=np.float64)


def _colours(curves: Mapping[str, Any]) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(len(curves))]


def _legend(axes: Axes) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend()
