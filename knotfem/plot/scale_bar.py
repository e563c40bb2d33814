"""A bar of known length in pictures of a parallel projection."""

from __future__ import annotations

import math
from typing import Any

LONGEST = 0.3
"""Of the picture's width."""
STRIP = 0.07
"""Height of the strip at the lower edge that is left for the bar, over that of the picture."""


def round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10, 20, ... that is not above `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(digit * power for digit in (5.0, 2.0, 1.0) if digit * power <= most * (1.0 + 1e-12))


def add_scale_bar(plotter: Any, mm_per_pixel: float) -> float:
    """Draw a bar with its length beside it in the lower left corner; returns the length [mm].

    Args:
        plotter: of pyvista, with a parallel projection.
        mm_per_pixel: of the picture.
    """
    import pyvista as pv
    from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

    width, height = plotter.window_size
    length = round_length(LONGEST * width * mm_per_pixel)
    pixels, margin, tick = length / mm_per_pixel, height // 50, height / 140
    low, left = margin + tick, float(margin)
    corners = [(0.0, -tick), (0.0, tick), (0.0, 0.0), (pixels, 0.0), (pixels, -tick), (pixels, tick)]
    line = pv.PolyData()
    line.points = [(left + x, low + y, 0.0) for x, y in corners]
    line.lines = [2, 0, 1, 2, 2, 3, 2, 4, 5]
    mapper = vtkPolyDataMapper2D()
    mapper.SetInputData(line)
    bar = vtkActor2D()
    bar.SetMapper(mapper)
    bar.GetProperty().SetColor(0.0, 0.0, 0.0)
    bar.GetProperty().SetLineWidth(max(1.0, height / 350))
    plotter.add_actor(bar, render=False)
    place = (left + pixels + margin, low)
    label = plotter.add_text(f"{length:g} mm", position=place, font_size=max(6, height // 85), color="black")
    label.prop.justification_horizontal = "left"
    label.prop.justification_vertical = "center"
    return length
