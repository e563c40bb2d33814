"""Curves of a run on paper: force, tension, stretch while tying (matplotlib, no display needed)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.plot.curves import (
    ARCLENGTH_LABELS,
    COLOURS,
    TENSION_LABELS,
    Table,
    column,
    draw_force,
    draw_profiles,
    legend,
    styles,
)
from knotfem.plot.fonts import literal
from knotfem.plot.paper import COLUMN, Sheet, paper_axes, written
from knotfem.types import Array


def plot_force(
    curves: Mapping[str, Table],
    out: str | Path,
    *,
    radius: float,
    title: str | None = None,
    bands: Mapping[str, float] | None = None,
    unbalanced: Sequence[tuple[float, float]] = (),
) -> None:
    """Draw force against displacement of the pulled end.

    Args:
        curves: tables with the columns `displacement_mm` and `force_N` (of force.csv), by label.
        out: file to write (.png, .pdf, .svg).
        radius: radius of the rod in mm; displacement is drawn in radii below and in mm above.
        title: heading.
        bands: half the width [N] of a band around a curve, by its label.
        unbalanced: displacements [mm] between which the one curve is not of equilibria, shaded.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    with paper_axes(out, title) as axes:
        draw_force(axes, curves, dict.fromkeys(curves, radius), axis="both", bands=bands, unbalanced=unbalanced)


def plot_comparison(
    forces: Mapping[str, Table],
    profiles: Mapping[str, Mapping[str, Table]],
    out: str | Path,
    *,
    radii: Mapping[str, float],
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
        radii: of the rods [mm], by label; where they differ, displacements are drawn in mm.
        locking: displacement in mm at which the knot begins to lock, drawn dashed.
        over_force: whether tension is T/F instead of T in N.
        at: displacement in mm of each run's profile.
        step: at whose end the profiles are.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    count = bool(forces) + bool(profiles)
    with written(out, None, count, Sheet(count * COLUMN)) as panels:
        if forces:
            same = len(set(radii.values())) == 1
            draw_force(panels[0], forces, radii, axis="both" if same else "mm")
            if locking is not None:
                unit = next(iter(radii.values())) if same else 1.0
                panels[0].axvline(locking / unit, color="0.5", lw=0.8, ls="--", label="begins to lock")
                legend(panels[0])
        if profiles:
            draw_profiles(panels[-1], profiles, named=not forces)
            panels[-1].set_ylabel(TENSION_LABELS["T/F" if over_force else "N"])
            places = ", ".join(dict.fromkeys(f"{place:.4g}" for place in at or ()))
            heading = rf"$\delta = {places}$ mm" if places else f"end of {step}" if step else ""
            panels[-1].set_title(heading, fontsize=9)


def plot_tension(
    curves: Mapping[str, Table],
    out: str | Path,
    *,
    applied: float | None,
    levels: Sequence[float] = (),
    drops: Sequence[tuple[float, float]] = (),
    title: str | None = None,
) -> None:
    """Draw the tension along the centreline.

    One table is drawn in all its parts: nodal forces across each section, the integral of stresses, and below these,
    on an axis of their own, core and bulk apart. Several are drawn by their nodal forces.

    Args:
        curves: tables with the columns `s_over_L`, `tension_N`, `core_N` and `bulk_N` (of tension.csv), by label.
        out: file to write (.png, .pdf, .svg).
        applied: force F at the reported end in N, the unit of the vertical axis; None for N.
        levels: expected levels of the vertical axis, drawn dashed (plateau, tail load).
        drops: intervals of s/L in which a drop is expected, shaded.
        title: heading.

    Raises:
        InputError: a column or the format is unknown, or the file cannot be written.
    """
    unit = 1.0 if applied is None else applied
    whole = Sheet()
    parted = len(curves) == 1
    sheet = replace(whole, height=1.4 * whole.height) if parted else whole
    with written(out, title, 1, sheet, rows=(2.0, 1.0) if parted else (1.0,)) as (axes, *below):
        for start, end in drops:
            axes.axvspan(start, end, color="0.93", lw=0)
        for level in levels:
            axes.axhline(level, color="0.5", lw=0.8, ls="--")
        for (colour, line), (label, table) in zip(styles(curves), curves.items(), strict=True):
            s, tension = column(table, "s_over_L"), column(table, "tension_N") / unit
            axes.plot(s, tension, color=colour, ls=line, label=literal(label) or "nodal forces", zorder=3)
            for lower in below:
                core, bulk = column(table, "core_N") / unit, column(table, "bulk_N") / unit
                every = max(1, len(s) // 60)
                style: dict[str, Any] = {"ls": "none", "marker": "o", "ms": 3.2, "mfc": "none", "mew": 0.8, "zorder": 4}
                axes.plot(s[::every], (core + bulk)[::every], color="k", label="stresses", **style)
                lower.plot(s, core, color=COLOURS[1], lw=0.9, label="core")
                lower.plot(s, bulk, color=COLOURS[2], lw=0.9, label="bulk")
                lower.set_ylabel("parts (N)" if applied is None else r"parts, over $F$")
                legend(lower)
        axes.set(ylabel=TENSION_LABELS["N" if applied is None else "T/F"], xlim=(0, 1))
        (axes, *below)[-1].set_xlabel(ARCLENGTH_LABELS["s_over_L"])
        legend(axes)


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
