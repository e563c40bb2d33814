"""The stability diagram on paper, after Fig. 4b of Aymon et al., Extreme Mech. Lett. 81, 102413 (2025)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from knotfem.plot.curves import COLOURS
from knotfem.plot.paper import paper_axes
from knotfem.theory import central_rods_friction, critical_friction, wrapping_rod_friction
from knotfem.types import Arrays

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MODEL_WORDS = {"fem": "hexahedra", "rod": "discrete rods"}
"""Models as legends name them."""
GREEN, RED, ORANGE, GREY = "#2E8B57", "#C0392B", "#E67E22", "0.5"
Boundary = tuple[np.ndarray, np.ndarray, np.ndarray]
_LOOKS = {
    "holds": ("o", GREEN, "holds"),
    ("unravels", "central"): ("x", RED, "unravels, central strands slip"),
    ("unravels", "wrapping"): ("+", ORANGE, "unravels, wrapping strand slips"),
    "unravels": ("x", GREY, "unravels"),
    "slips": ("v", ORANGE, "slips"),
}
OTHER = ("s", GREY, "undecided")


def plot_stability(
    points: Arrays,
    boundaries: Mapping[str, Boundary],
    out: str | Path,
    *,
    force: float,
    theory: bool,
    title: str | None = None,
) -> None:
    """Draw verdicts in the plane of friction and B/(T0 r^2), with the load T0 on the right-hand axis.

    Args:
        points: columns "model", "friction", "x", "verdict" and "failure_mode", each of shape [points]; where there are
            two models, the marks of discrete rods are the smaller ones.
        boundaries: friction, half the width of its bracket, and x, each of shape [loads], by label.
        out: file to write (.png, .pdf, .svg).
        force: B/r^2 [N].
        theory: whether to shade where the theory of the bowline has it hold, and to draw both of its modes.
        title: heading.

    Raises:
        InputError: the format is unknown or the file cannot be written.
    """
    x, mu = points["x"], points["friction"]
    loads = np.concatenate([x, *(b[2] for b in boundaries.values())])
    lowest, highest = float(loads.min()), float(loads.max())
    right = max([0.4, *mu.tolist(), *(float(b[0].max(initial=0.0)) for b in boundaries.values())]) * 1.05
    with paper_axes(out, title, width=5.6) as axes:
        axes.set(xlabel=r"friction coefficient $\mu$", ylabel=r"$B\, /\, (T_0 r^2)$", xlim=(-0.015, right))
        if highest > 20.0 * lowest:
            axes.set_yscale("log")
            axes.set_ylim(lowest / 1.5, highest * 1.5)
        else:
            axes.set_ylim(max(0.0, lowest - 2.0), highest + 2.0)
        if theory:
            _draw_theory(axes, right)
        several = len(set(points["model"].tolist())) > 1
        looks = [_look(v, m) for v, m in zip(points["verdict"], points["failure_mode"], strict=True)]
        for look in dict.fromkeys(looks):
            marker, colour, label = look
            for model in dict.fromkeys(points["model"].tolist()):
                of = np.array([one == look for one in looks]) & (points["model"] == model)
                size = 4.0 if several and model == "rod" else 6.5
                if of.any():
                    axes.plot(
                        mu[of], x[of], ls="none", marker=marker, ms=size, mew=1.1, mfc="none", color=colour,
                        label=label if not several else f"{label} ({MODEL_WORDS[model]})",
                    )  # fmt: skip
        for number, (label, (middle, half, at)) in enumerate(boundaries.items()):
            colour = ("black", *COLOURS)[number % 8]
            axes.errorbar(middle, at, xerr=half, color=colour, marker="s", ms=3.5, lw=0.9, capsize=2, label=label)
        _add_load(axes, force, lowest if lowest == highest else None)
        figure = axes.get_figure()
        assert figure is not None
        figure.legend(loc="outside right upper")


def _look(verdict: str, mode: str) -> tuple[str, str, str]:
    return _LOOKS.get((verdict, mode), _LOOKS.get(verdict, OTHER))


def _add_load(axes: Axes, force: float, only: float | None) -> None:
    """The load [N] at the ticks of B/(T0 r^2), on the right; where there is one value only, both have a tick there."""
    right = axes.secondary_yaxis("right")
    right.set_ylabel(r"$T_0$ (N)")
    right.yaxis.set_major_formatter(lambda x, _: f"{force / x:.3g}" if x > 0.0 else "")
    if only is not None:
        axes.set_yticks([only])
        right.set_yticks([only])
    axes.tick_params(right=False)


def _draw_theory(axes: Axes, right: float) -> None:
    """Where the bowline holds, and the threshold of either mode."""
    lowest, highest = axes.get_ylim()
    x = np.geomspace(max(lowest, 1e-2), highest, 400)
    threshold, central = critical_friction(x), central_rods_friction(x)
    axes.fill_betweenx(x, threshold, right, color=GREEN, alpha=0.10, lw=0)
    by_central = central >= wrapping_rod_friction()
    for of, colour in ((by_central, RED), (~by_central, ORANGE)):
        axes.fill_betweenx(x, -0.015, threshold, where=of, color=colour, alpha=0.10, lw=0)
    axes.plot(central, x, color="0.25", lw=1.1, ls="--", label="theory, central strands")
    axes.axvline(wrapping_rod_friction(), color="0.25", lw=1.1, ls=":", label="theory, wrapping strand")
