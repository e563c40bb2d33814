"""`knotfem compare`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

import knotfem as kf
from knotfem_cli.common import Verb, at_option, displacement, output_option, shared_options

if TYPE_CHECKING:
    from knotfem.results.compare import Cell, Figure


@click.command(cls=Verb)
@click.argument("runs", metavar="RUN RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@output_option
@at_option
@click.option("--step", metavar="NAME", help="Tension at the end of this step; of the last that all have, by default.")
@click.option("--locking", metavar="LENGTH", help="Where the knot begins to lock; found in the first run by default.")
@shared_options
def compare(
    runs: tuple[Path, ...],
    output: Path | None,
    at: str | None,
    step: str | None,
    locking: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Hold runs against the first of them, whatever their models.

    Draws force curves of pulls and tension profiles over each other (compare.png, or the file that -o names), prints
    the differences and writes them into a table beside the picture (compare.csv).

    \b
    Example:
      knotfem compare runs/bowline-1 runs/bowline-2
      knotfem compare solid light -o solid-light.pdf --at "60 mm"
      knotfem compare solid light --step load
    """
    opened = [kf.open_run(run, overrides) for run in runs]
    found = kf.compare(*opened, locking=displacement(locking, "--locking"), at=displacement(at), step=step)
    picture = output or Path("compare.png")
    table = found.write(picture)
    labels = [curve.label for curve in found.curves]
    if log_format == "json":
        figures = {f.name: {"unit": f.unit, **dict(zip(labels, f.cells, strict=True))} for f in found.figures}
        click.echo(json.dumps({"picture": str(picture), "table": str(table), "figures": figures}))
        return
    if not quiet:
        _print(labels, found.figures)
    click.echo(picture)
    click.echo(table)


def _print(labels: list[str], figures: list[Figure]) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table("", *labels)
    for column in table.columns[1:]:
        column.justify = "right"
    for figure in figures:
        unit = f" [{figure.unit}]" if figure.unit in ("mm", "N", "s") else ""
        table.add_row(escape(figure.name + unit), *(_shown(value, figure.unit) for value in figure.cells))
    Console(stderr=True).print(table)


def _shown(value: Cell, unit: str) -> str:
    from knotfem.results.compare import RELATIVE

    if not isinstance(value, float):
        return "-" if value is None else str(value)
    return f"{100.0 * value:.2f} %" if unit == RELATIVE else f"{value:.4g}"
