"""The colour bar of pictures, in a strip at their right-hand edge."""

from __future__ import annotations

from typing import Any

import numpy as np

from knotfem.plot.scale_bar import add_white
from knotfem.types import Array

BAR = 0.16
"""Width of the strip that is left for the bar, over the height of the picture."""
BOTTOM, HEIGHT = 0.15, 0.7
"""Of the bar, over the height of the picture."""
ABOUT = 5
"""Ticks, at most one more."""


def round_ticks(low: float, high: float) -> Array:
    """Round numbers from one value to another, evenly spaced.

    Args:
        low: lower end of the bar.
        high: upper end.
    """
    from matplotlib.ticker import MaxNLocator

    ticks = np.asarray(MaxNLocator(ABOUT, steps=[1, 2, 5, 10]).tick_values(low, high))
    slack = 1e-9 * (high - low)
    return ticks[(ticks >= low - slack) & (ticks <= high + slack)]


def add_colour_bar(plotter: Any, mapper: Any) -> None:
    """Draw the bar; rods that are behind it show through faintly.

    Args:
        plotter: of pyvista.
        mapper: of the rod whose colours it explains.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk

    width, height = plotter.window_size
    low, high = width - BAR * height, BOTTOM * height - 0.03 * height
    add_white(plotter, (low, high), (width, height - high), opacity=0.8)
    ticks = round_ticks(*mapper.scalar_range)
    bar = plotter.add_scalar_bar(
        title=" ",
        mapper=mapper,
        vertical=True,
        position_x=1 - 0.13 * height / width,
        position_y=BOTTOM,
        width=0.05 * height / width,
        height=HEIGHT,
        label_font_size=height // 42,
        n_labels=len(ticks),
        fmt="{:.6g}" if _formats_braces() else "%.6g",
        color="black",
    )
    bar.SetCustomLabels(numpy_to_vtk(ticks, deep=True))
    bar.UseCustomLabelsOn()


def _formats_braces() -> bool:
    """VTK 9.6 and later format numbers by braces instead of printf."""
    from vtkmodules.vtkCommonCore import vtkVersion

    return (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 6)
