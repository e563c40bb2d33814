"""`knotfem plot`."""

from __future__ import annotations

import json
from pathlib import Path

import click

import knotfem as kf
from knotfem.errors import InputError
from knotfem_cli.common import (
    Verb,
    at_option,
    displacement,
    moment_json,
    output_option,
    say_state,
    shared_options,
    step_option,
)


@click.command(cls=Verb)
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@output_option
@click.option("--quantity", type=click.Choice(["force", "tension", "both"]), default="force", show_default=True,
              help="Force against displacement, tension along the rods.")  # fmt: skip
@click.option("--width", metavar="LENGTH", help='Of the figure, such as "85 mm"; 91 mm a panel by default.')
@click.option("--height", metavar="LENGTH", help="Likewise; in proportion by default.")
@click.option("--font", type=float, default=9.0, show_default=True, help="Size of letters in points.")
@click.option("--axis", type=click.Choice(["both", "radii", "mm"]),
              help="Displacement over the radius, in mm, or both (the default).")  # fmt: skip
@click.option("--force-unit", type=click.Choice(["N", "B/r^2"]), default="N", show_default=True,
              help="Of the vertical axis.")  # fmt: skip
@click.option("--label", "labels", metavar="TEXT", multiple=True, help="Of each run in turn; repeatable.")
@click.option("--xlim", metavar="LOW:HIGH", help='Of the horizontal axis, such as "0:30" or ":30".')
@click.option("--ylim", metavar="LOW:HIGH", help="Of the vertical axis.")
@at_option
@step_option
@click.option("--title", metavar="TEXT", help="Heading.")
@shared_options
def plot(
    runs: tuple[Path, ...],
    output: Path | None,
    quantity: str,
    width: str | None,
    height: str | None,
    font: float,
    axis: str | None,
    force_unit: str,
    labels: tuple[str, ...],
    xlim: str | None,
    ylim: str | None,
    at: str | None,
    step: str | None,
    title: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Draw figures of one or more runs, however they ended.

    Force against displacement, tension along the rods, or both side by side, as PDF, SVG or PNG in the size of a
    journal's column. Prints the file's name, plot.png by default.

    \b
    Example:
      knotfem plot runs/bowline-1
      knotfem plot solid light -o force.pdf --width "85 mm" \\
        --label hexahedra --label rods --axis radii --xlim 0:33
      knotfem plot solid --quantity tension --at "60 mm" -o tension.svg
    """
    out, millimetres = output or Path("plot.png"), displacement(at)
    drawn = kf.plot(
        *(kf.open_run(run, overrides) for run in runs),
        out=out,
        quantity=quantity,  # pyright: ignore[reportArgumentType]
        width=width,
        height=height,
        font=font,
        axis=axis,  # pyright: ignore[reportArgumentType]
        force_unit=force_unit,  # pyright: ignore[reportArgumentType]
        labels=labels,
        xlim=_limits(xlim, "xlim"),
        ylim=_limits(ylim, "ylim"),
        at=millimetres,
        step=step,
        title=title,
    )
    moments = {label: profile.moment for label, profile in zip(drawn.labels, drawn.profiles, strict=False)}
    if log_format == "json":
        states = {label: moment_json(moment) for label, moment in moments.items()}
        click.echo(json.dumps({"picture": str(out), "states": states, "out_of_view": drawn.out_of_view}))
        return
    if not quiet:
        for label in drawn.out_of_view:
            click.echo(f"{label}: nothing lies between these limits", err=True)
        for label, moment in moments.items():
            say_state(millimetres, moment, label if len(moments) > 1 else "")
    click.echo(out)


def _limits(text: str | None, key: str) -> tuple[float | None, float | None]:
    """Smallest and largest value of an axis."""
    if text is None:
        return None, None
    parts = text.split(":")
    try:
        low, high = (float(part) if part.strip() else None for part in parts)
    except ValueError:
        expected = 'two numbers in the units of the axis, such as "0:30" or ":30"'
        raise InputError("no limits", key=key, found=f'"{text}"', expected=expected) from None
    return low, high
