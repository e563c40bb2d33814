"""Error against cost on paper, the Pareto front marked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from knotfem.plot.curves import COLOURS
from knotfem.plot.paper import paper_axes

if TYPE_CHECKING:
    from matplotlib.axis import Axis

MARKERS = "osD^v<>Ph*"


def plot_pareto(
    series: Mapping[str, Sequence[tuple[float, float]]],
    front: Sequence[tuple[float, float, float]],
    out: str | Path,
    *,
    label: str,
    uncertainty: float = 0.0,
    unordered: Collection[str] = (),
    title: str | None = None,
) -> None:
    """Draw relative errors against CPU seconds, on logarithmic axes.

    Args:
        series: CPU seconds and relative error of each refinement level, from coarse to fine, by series.
        front: those that none beats, by rising cost: CPU seconds, error, and the larger bound on it,
            which is ringed.
        out: file to write (.png, .pdf, .svg).
        label: what the error is of.
        uncertainty: of the reference; errors below it, shaded, say nothing.
        unordered: series whose levels have no order, drawn without lines.
        title: heading.

    Raises:
        InputError: the format is unknown or the file cannot be written.
    """
    drawn = [point for points in series.values() for point in points]
    with paper_axes(out, title, width=5.4) as axes:
        axes.set(xscale="log", yscale="log", xlabel="CPU time (s)", ylabel=f"error, {label}")
        for number, (name, points) in enumerate(series.items()):
            if points:
                seconds, errors = zip(*points, strict=True)
                style = "none" if name in unordered else "-"
                colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
                axes.plot(seconds, errors, color=colour, marker=marker, ms=4, lw=0.8, ls=style, label=name)
        if drawn:
            seconds, errors = zip(*drawn, strict=True)
            axes.set(xlim=(min(seconds) / 1.3, max(seconds) * 1.3), ylim=(min(errors) / 2.0, max(errors) * 2.0))
        if front:
            seconds, found, bound = zip(*front, strict=True)
            axes.vlines(seconds, found, bound, color="0.2", lw=0.8)
            axes.plot(seconds, bound, ls="none", marker="o", ms=11, mfc="none", mec="0.2", mew=1.2, label="front")
            steps = list(zip(seconds, bound, strict=True))
            reach = [(seconds[0], axes.get_ylim()[1]), *steps, (axes.get_xlim()[1], bound[-1])]
            axes.plot(*zip(*reach, strict=True), color="0.2", lw=0.8, ls="--", drawstyle="steps-post")
        if uncertainty > 0.0:
            axes.axhspan(axes.get_ylim()[0], uncertainty, color="0.9", lw=0, zorder=0)
        if drawn:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.02))
            _plain_ticks(axes.xaxis, 1.0)
            _plain_ticks(axes.yaxis, 100.0, " %")


def _plain_ticks(axis: Axis, factor: float, unit: str = "") -> None:
    """Ticks at 1, 2 and 5 of a decade, written out in a unit that is `factor` times finer."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{factor * value:.4g}{unit}"))
    axis.set_minor_formatter(NullFormatter())
