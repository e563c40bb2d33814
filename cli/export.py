"""`knotfem export`."""

from __future__ import annotations

import json
from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import (
    Verb,
    at_option,
    displacement,
    model_option,
    moment_json,
    run_argument,
    say_state,
    shared_options,
    step_option,
    with_model,
)


@click.command(cls=Verb)
@run_argument
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="Where to write: .inp, .msh, .vtu or .xdmf."
)
@at_option
@step_option
@click.option("--reference", is_flag=True, help="The straight rods instead of the deformed ones.")
@model_option
@shared_options
def export(
    run: Path,
    output: Path,
    at: str | None,
    step: str | None,
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
    state = kf.export(opened, output, millimetres, step=step, reference=reference)
    if log_format == "json":
        click.echo(json.dumps({"file": str(output), **moment_json(state.moment)}))
    elif not quiet:
        say_state(millimetres, state.moment)
        click.echo(output)
