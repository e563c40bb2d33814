"""`knotfem tension`."""

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
    output_option,
    run_argument,
    say_state,
    shared_options,
    step_option,
    with_model,
)


@click.command(cls=Verb)
@run_argument
@output_option
@at_option
@step_option
@model_option
@shared_options
def tension(
    run: Path,
    output: Path | None,
    at: str | None,
    step: str | None,
    model: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Write the tension profile along the centreline.

    A CSV table on standard output, or into the file that -o names; with --log-format json, columns as JSON.

    \b
    Example:
      knotfem tension runs/bowline-1 -o tension.csv
      knotfem tension runs/bowline-1 --at "60 mm"
    """
    opened, millimetres = kf.open_run(run, with_model(overrides, model)), displacement(at)
    from knotfem.run.directory import RunDirectory
    from knotfem.run.tables import table_text, write_table

    profile = opened.tension(millimetres, step)
    if output is not None:
        RunDirectory(run).spare(output)
        write_table(output, profile.table)
    elif log_format == "json":
        click.echo(json.dumps({name: column.tolist() for name, column in profile.table.items()}))
    else:
        click.echo(table_text(profile.table), nl=False)
    if quiet or log_format == "json":
        return
    say_state(millimetres, profile.moment)
    for rod in profile.rods:
        force = profile.of(rod).tension
        text = f"{rod}: {force[0]:.4f} N at the start, {force[-1]:.4f} N at the end, at most {force.max():.4f} N"
        click.echo(text, err=True)
