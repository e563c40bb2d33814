"""Error against cost on paper, the Pareto front marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from knotfem.report.plots import COLOURS, paper_axes

MARKERS = "osD^v<>Ph*"


def plot_pareto(
    ladders: Mapping[str, Sequence[tuple[float, float]]],
    front: Sequence[tuple[float, float]],
    out: str | Path,
    *,
    label: str,
    uncertainty: float = 0.0,
    title: str | None = None,
) -> None:
    """Draw relative errors against CPU seconds, on logarithmic axes.

    Args:
        ladders: CPU seconds and relative error of each rung, from coarse to fine, by ladder.
        front: those that none beats, by rising cost.
        out: file to write (.png, .pdf, .svg).
        label: what the error is of.
        uncertainty: of the reference; errors below it, shaded, say nothing.
        title: heading.

    Raises:
        InputError: the format is unknown or the file cannot be written.
    """
    with paper_axes(out, title, width=4.6) as axes:
        axes.margins(x=0.08)
        if front:
            steps = [(front[0][0], 1e3 * front[0][1]), *front, (1e3 * front[-1][0], front[-1][1])]
            seconds, errors = zip(*front, strict=True)
            axes.plot(seconds, errors, ls="none", marker="o", ms=11, mfc="none", mec="0.2", mew=1.2, label="front")
            seconds, errors = zip(*steps, strict=True)
            axes.plot(seconds, errors, color="0.2", lw=0.8, ls="--", drawstyle="steps-post", scalex=False, scaley=False)
        for number, (name, points) in enumerate(ladders.items()):
            if not points:
                continue
            seconds, errors = zip(*points, strict=True)
            colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
            axes.plot(seconds, errors, color=colour, marker=marker, ms=4, lw=0.8, label=name)
        axes.set(xscale="log", yscale="log", xlabel="CPU time (s)", ylabel=f"relative error, {label}")
        if uncertainty > 0.0:
            axes.axhspan(axes.get_ylim()[0], uncertainty, color="0.9", lw=0, zorder=0)
        if any(ladders.values()):
            axes.legend(ncols=2)
