"""`knotfem check`."""

from __future__ import annotations

import json

import click

import knotfem as kf
from knotfem_cli.common import Verb, facts, from_option, last_option, model_option, shared_options, with_model


@click.command(cls=Verb)
@click.argument("scene")
@model_option
@from_option
@last_option
@shared_options
def check(
    scene: str,
    model: str | None,
    from_run: str | None,
    last: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Validate a scene and say what it would take; run nothing.

    Prints the resolved scene with every default, the effects that will run and those that will not, degrees of
    freedom, expected memory and time. With --quiet, only whether the scene is right.

    \b
    Example:
      knotfem check bowline --set 'rods.0.mesh.element_length=1 mm'
    """
    from knotfem.scene import scene_to_toml

    resolved = kf.load_scene(scene, with_model(overrides, model, from_run, last))
    found = kf.check(resolved)
    if log_format == "json":
        click.echo(json.dumps({"scene": resolved.model_dump(mode="json"), **found}))
    elif not quiet:
        click.echo(scene_to_toml(resolved))
        click.echo(facts(found))
