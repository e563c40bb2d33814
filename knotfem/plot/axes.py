"""Axes to draw on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from knotfem.plot.curves import COLOURS
from knotfem.plot.paper import MM_PER_INCH, Sheet, panels_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@contextmanager
def axes_for(axes: Axes | None) -> Iterator[Axes]:
    """The given axes, or those of a new figure of pyplot in the style of `knotfem plot`; to be drawn on within."""
    if axes is not None:
        yield axes
        return
    from cycler import cycler
    from matplotlib import pyplot

    sheet = Sheet()
    with pyplot.rc_context({**sheet.style, "axes.prop_cycle": cycler(color=COLOURS)}):
        size = (sheet.width / MM_PER_INCH, sheet.height / MM_PER_INCH)
        yield panels_of(pyplot.figure(figsize=size, dpi=sheet.dpi, layout="constrained"), 1)[0]
