"""`knotfem hold`."""

from __future__ import annotations

from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import (
    Verb,
    ask_before,
    force_option,
    model_option,
    numbers,
    output_option,
    progress_of,
    rope_option,
    scene_for,
    shared_options,
    show_run,
    with_model,
    yes_option,
)


@click.command(cls=Verb)
@click.argument("scene")
@output_option
@force_option
@model_option
@click.option("--tighten", metavar="FORCE", required=True, help='On the loaded ends at first, such as "2 N".')
@click.option("--slip", metavar="LENGTH", help="By which a free end may be drawn in; one diameter by default.")
@click.option("--displacement", metavar="LENGTH", help="Of the pull at most; 5 times the slip by default.")
@click.option("--free-load", type=float, default=0.0, help="Force on a free end over the one that tightens.")
@click.option("--direction", metavar="X,Y,Z", help="Of this force; opposite to the pull by default.")
@rope_option
@yes_option
@shared_options
def hold(
    scene: str,
    output: Path | None,
    force: bool,
    model: str | None,
    tighten: str,
    slip: str | None,
    displacement: str | None,
    free_load: float,
    direction: str | None,
    rope: tuple[str, ...],
    yes: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Say how much a knot holds before it slips.

    The loaded ends of the scene bear a force, its free ends being held, until the rods are at rest. Then the loaded
    ends are held and the free ones let go. Then the loaded ends are pulled on until a free end has been drawn in by the
    slip. The holding force is the largest one before; the run directory, which is printed, has all of its force curve.
    Weight is left out.

    \b
    Example:
      knotfem hold bowline --model rod --tighten "1 N"
      knotfem hold clove-hitch --model rod --tighten "2 N" --slip "3 mm" -o hitch
      knotfem hold clove-hitch --model rod --tighten "20 N" --rope diameter="10 mm" friction=0.25
    """
    from knotfem.study.dead_load import free_directions
    from knotfem.study.holding import holding_scene

    source, progress = scene_for(scene, with_model(overrides, model), rope), progress_of(quiet, log_format)
    if rope:
        progress.message(f"rope: {source.rope}")
    free = None if direction is None else free_directions(source, (), numbers(direction, "--direction"))
    wanted = holding_scene(
        source, tighten, slip=slip, displacement=displacement, free=free, free_load=free_load
    )  # fmt: skip
    ask_before(wanted, yes)
    run = kf.pull(wanted, out=output or True, force=force, progress=progress)
    show_run(run, quiet, log_format)
    if run.holding() is None and not quiet and log_format == "text":
        click.echo("holding force 0: the knot was lost before it was pulled", err=True)
