"""`knotfem scenes`."""

from __future__ import annotations

import json

import click

from knotfem_cli.common import Verb, shared_options
from knotfem_cli.text import facts, width_of


@click.command(cls=Verb)
@shared_options
def scenes(overrides: tuple[str, ...], quiet: bool, log_format: str) -> None:
    """List the scenes and knots that ship with the program.

    With --set, only scenes that take the change are listed. With --quiet, names only.

    \b
    Example:
      knotfem scenes
      knotfem pull overhand --set rods.0.centerline=figure_eight --set 'rods.0.length=528 mm'
    """
    from knotfem import shipped
    from knotfem.scene.load import describe

    found = {name: text for name in shipped.scene_names() if (text := describe(name, overrides)) is not None}
    knots = {name: shipped.centreline_title(name) for name in shipped.centreline_names()}
    if log_format == "json":
        click.echo(json.dumps({"scenes": found, "centerlines": knots}))
    elif quiet:
        click.echo("\n".join(found))
    else:
        click.echo(facts({"scenes": found, "centrelines (rods.0.centreline)": knots}, width=width_of()))
