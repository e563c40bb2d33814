"""Figures of the sizes of journals: style, panels, files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from knotfem.errors import InputError, MissingDependency
from knotfem.files import write_atomically
from knotfem.plot.fonts import use_fonts_for, without_glyph_warnings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".pdf", ".svg")
MM_PER_INCH = 25.4
COLUMN = 91.44
"""Width of a figure in one column [mm]."""


@dataclass(frozen=True)
class Sheet:
    """Size of a figure on paper.

    Attributes:
        width: of all panels together [mm].
        height: [mm].
        font: size of names and numbers [pt].
        dpi: dots per inch of a .png file.
    """

    width: float = COLUMN
    height: float = 71.12
    font: float = 9.0
    dpi: float = 200.0

    @property
    def style(self) -> Any:
        """Settings of matplotlib, by their names."""
        return {
            "font.size": self.font,
            "axes.labelsize": self.font + 1.0,
            "axes.linewidth": 0.8,
            "axes.xmargin": 0.0,
            "xtick.major.pad": 0.6 * self.font,
            "ytick.major.pad": 0.6 * self.font,
            "xtick.direction": "in",
            "ytick.direction": "in",
            "ytick.right": True,
            "legend.frameon": False,
            "legend.fontsize": self.font - 1.0,
            "lines.linewidth": 1.4,
            "savefig.dpi": self.dpi,
            "svg.fonttype": "none",
            "pdf.fonttype": 42,
        }


def check_format(out: Path) -> None:
    """Refuse a file whose suffix names no format.

    Raises:
        InputError: it does not.
    """
    if out.suffix.lower() not in SUFFIXES:
        found = out.suffix or "no suffix"
        raise InputError("no such picture format", file=out, found=found, expected=", ".join(SUFFIXES))


@contextmanager
def paper_axes(out: str | Path, title: str | None, *, width: float = 3.6) -> Iterator[Axes]:
    """Axes of a figure of a width [inches], which is then written as a whole."""
    with written(out, title, 1, Sheet(width * MM_PER_INCH)) as panels:
        yield panels[0]


@contextmanager
def written(
    out: str | Path, title: str | None, count: int, sheet: Sheet | None = None, *, rows: Sequence[float] = (1.0,)
) -> Iterator[list[Axes]]:
    """Panels of a figure that is then written as a whole; arguments as for `panels_of`.

    Raises:
        InputError: the format is unknown or the file cannot be written.
        MissingDependency: matplotlib is absent.
    """
    out, sheet = Path(out), sheet or Sheet()
    check_format(out)
    with drawing(sheet) as figure:
        panels = panels_of(figure, count, rows)
        yield panels
        if title:
            panels[0].set_title(title, fontsize=sheet.font + 1.0)
        write(figure, out)


@contextmanager
def drawing(sheet: Sheet) -> Iterator[Figure]:
    """An empty figure without a display, and matplotlib in the style of papers.

    Raises:
        MissingDependency: matplotlib is absent.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingDependency(f"plots need matplotlib ({error}): pip install matplotlib") from error

    with rc_context(sheet.style):
        size = (sheet.width / MM_PER_INCH, sheet.height / MM_PER_INCH)
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure


def panels_of(figure: Figure, count: int, rows: Sequence[float] = (1.0,)) -> list[Axes]:
    """Axes of a figure, row by row.

    Args:
        figure: empty.
        count: side by side.
        rows: heights of the rows, in proportion; the panels below each other share their horizontal axis.
    """
    grid = figure.subplots(len(rows), count, sharex="col", squeeze=False, height_ratios=list(rows))
    panels: list[Axes] = [axes for row in grid for axes in row]
    for axes in panels:
        axes.grid(True, lw=0.4, color="0.9")
        axes.set_axisbelow(True)
    return panels


def write(figure: Figure, out: Path) -> None:
    """Write a figure of `drawing`, within it, as a whole.

    Raises:
        InputError: the format is unknown or the file cannot be written.
    """
    check_format(out)
    picture = BytesIO()
    use_fonts_for(figure)
    with without_glyph_warnings():
        figure.savefig(picture, format=out.suffix[1:].lower())
    write_atomically(out, picture.getvalue())
