"""`knotfem compare`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import Verb, at_option, displacement, output_option, shared_options
from knotfem_cli.text import width_of


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
        from knotfem.results.compare_text import comparison_text

        click.echo(comparison_text(labels, found.figures, width_of(sys.stderr)), err=True)
    click.echo(picture)
    click.echo(table)
