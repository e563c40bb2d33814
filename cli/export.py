"""`knotfem export`."""

from __future__ import annotations

import json
import math
from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import (
    Verb,
    at_option,
    displacement,
    model_option,
    run_argument,
    say_nearest,
    shared_options,
    with_model,
)


@click.command(cls=Verb)
@run_argument
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="Where to write: .inp, .msh, .vtu or .xdmf."
)
@at_option
@click.option("--reference", is_flag=True, help="The straight rods instead of the deformed ones.")
@model_option
@shared_options
def export(
    run: Path,
    output: Path,
    at: str | None,
    reference: bool,
    model: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Write mesh and fields of a stored state for other programs.

    Gmsh (.msh), ParaView and other readers of VTK or XDMF (.vtu, .xdmf), or a deck for CalculiX and Abaqus (.inp).

    \b
    Example:
      knotfem export runs/bowline-1 --at "60 mm" -o knot.vtu
      knotfem export runs/cantilever-1 --reference -o rod.inp
    """
    opened, millimetres = kf.open_run(run, with_model(overrides, model)), displacement(at)
    state = kf.export(opened, output, millimetres, reference=reference)
    if log_format == "json":
        found = {"file": str(output), "time_s": state.time}
        if math.isfinite(state.displacement):
            found["displacement_mm"] = state.displacement
        click.echo(json.dumps(found))
    elif not quiet:
        say_nearest(millimetres, state.displacement)
        click.echo(output)
