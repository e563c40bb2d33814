"""The figures that a run draws by itself, from arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from knotfem.plot import plots

Table = Mapping[str, np.ndarray]


def draw_stretch(
    folder: Path, names: Sequence[str], slices: Sequence[int], times: Sequence[float], stretches: Sequence[np.ndarray],
    threshold: float,
) -> None:  # fmt: skip
    """Stretch of each rod's centreline against arclength, coloured by mapping time.

    Args:
        folder: of the run.
        names: of the rods.
        slices: of each rod.
        times: mapping times of the increments.
        stretches: of all edges at each, rods one behind the other.
        threshold: that the mapping aims at.
    """
    first = 0
    for name, count in zip(names, slices, strict=True):
        edges = slice(first, first + count)
        first += count
        plots.plot_stretch(
            (np.arange(count) + 0.5) / count,
            np.array([stretch[edges] for stretch in stretches]),
            np.array(times),
            folder / ("stretch.png" if len(names) == 1 else f"stretch-{name}.png"),
            threshold=threshold,
        )


def draw_curves(folder: Path, force: Table, tension: Table | None, *, radius: float, applied: float) -> None:
    """Force against displacement, and the last tension profile.

    Args:
        folder: of the run.
        force: columns of force.csv.
        tension: columns of one state of tension.csv, or None.
        radius: of the rod [mm].
        applied: force at the reported end [N]; 0 takes the largest tension.
    """
    if len(force["force_N"]):
        plots.plot_force({folder.name: force}, folder / "force.png", radius=radius)
    if tension is None:
        return
    rods = {name: tension["rod"] == name for name in np.unique(tension["rod"])}
    curves = {
        ("" if len(rods) == 1 else str(name)): {key: values[rows] for key, values in tension.items()}
        for name, rows in rods.items()
    }
    scale = applied or float(np.abs(tension["tension_N"]).max())
    plots.plot_tension(curves, folder / "tension.png", applied=scale)
