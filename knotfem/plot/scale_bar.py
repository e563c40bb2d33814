"""A bar of known length in pictures of a parallel projection."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

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

    width, height = plotter.window_size
    length = round_length(LONGEST * width * mm_per_pixel)
    pixels, margin, tick = length / mm_per_pixel, height // 50, height / 140
    low, left = margin + tick, float(margin)
    corners = [(0.0, -tick), (0.0, tick), (0.0, 0.0), (pixels, 0.0), (pixels, -tick), (pixels, tick)]
    line = pv.PolyData()
    line.points = [(left + x, low + y, 0.0) for x, y in corners]
    line.lines = [2, 0, 1, 2, 2, 3, 2, 4, 5]
    for grey, thickness in ((1.0, 3.0), (0.0, 1.0)):  # white around black, to be seen before rods
        _add_flat(plotter, line, grey).SetLineWidth(thickness * max(1.0, height / 350))
    place = (left + pixels + margin, low)
    label = plotter.add_text(f"{length:g} mm", position=place, font_size=max(6, height // 85), color="black")
    label.prop.justification_horizontal = "left"
    label.prop.justification_vertical = "center"
    on_white(label)
    return length


def on_white(text: Any) -> None:
    """Let a text of a picture be read before rods that are drawn behind it."""
    text.prop.background_color = "white"
    text.prop.background_opacity = 0.8


def add_white(plotter: Any, low: tuple[float, float], high: tuple[float, float], opacity: float) -> None:
    """Let rods show faintly in a rectangle of the picture, between two corners [pixels]."""
    import pyvista as pv

    (left, bottom), (right, top) = low, high
    corners = [(left, bottom, 0.0), (right, bottom, 0.0), (right, top, 0.0), (left, top, 0.0)]
    _add_flat(plotter, pv.PolyData(np.array(corners), [4, 0, 1, 2, 3]), 1.0).SetOpacity(opacity)


def _add_flat(plotter: Any, shape: Any, grey: float) -> Any:
    """Draw a shape with places in pixels; returns its properties."""
    from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

    mapper, actor = vtkPolyDataMapper2D(), vtkActor2D()
    mapper.SetInputData(shape)
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(grey, grey, grey)
    plotter.add_actor(actor, render=False)
    return actor.GetProperty()
