"""`knotfem render`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

import click

import knotfem as kf
from knotfem.run.colours import COLOURS, OLDER
from knotfem_cli.common import (
    Verb,
    at_option,
    displacement,
    model_option,
    moment_json,
    numbers,
    output_option,
    run_argument,
    say_state,
    shared_options,
    step_option,
    with_model,
)


class Colour(click.Choice):
    """Takes older names too."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name of a colour as it is now."""
        if value in OLDER:
            click.echo(f'"{value}" is called "{OLDER[value]}" now; the field "pressure" is the mean stress', err=True)
        return super().convert(OLDER.get(value, value), param, ctx)


@click.command(cls=Verb)
@run_argument
@output_option
@at_option
@step_option
@click.option(
    "--colour",
    "--color",
    "colour",
    type=Colour(list(COLOURS)),
    default="strain",
    show_default=True,
    help="What colours the rod.",
)
@click.option("--focus", type=click.Choice(["all", "knot"]), default="all", show_default=True,
              help="What fills the picture; the knot is where strands are close to each other.")  # fmt: skip
@click.option("--zoom", type=float, default=1.0, show_default=True, help="Larger by this factor, about its middle.")
@click.option("--view", metavar="X,Y,Z", help="Direction from the knot to the eye; chosen by default.")
@model_option
@shared_options
def render(
    run: Path,
    output: Path | None,
    at: str | None,
    step: str | None,
    colour: str,
    focus: Literal["all", "knot"],
    zoom: float,
    view: str | None,
    model: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Draw the knot, without a screen. Prints the picture's file name, in the run directory by default.

    \b
    Example:
      knotfem render runs/bowline-1 -o knot.png --colour tension
      knotfem render runs/bowline-1 --at "60 mm"
      knotfem render runs/bowline-1 --step relax
      knotfem render runs/bowline-1 --color contact-pressure --focus knot --zoom 1.5
      knotfem render runs/bowline-1 --view 1,-2,0.5
    """
    eye = None if view is None else numbers(view, "--view")
    drawn, millimetres = kf.open_run(run, with_model(overrides, model)), displacement(at)
    out = output or run / f"knot-{colour}.png"
    state = drawn.state(millimetres, step)
    state.render(out, colour, focus=focus, zoom=zoom, view=eye)
    if log_format == "json":
        click.echo(json.dumps({"picture": str(out), "state": moment_json(state.moment)}))
    elif not quiet:
        say_state(millimetres, state.moment)
        click.echo(out)
