"""`knotfem help`."""

from __future__ import annotations

import json

import click

from knotfem_cli.common import Verb, shared_options
from knotfem_cli.text import spoken, width_of, wrapped


@click.command(cls=Verb)
@click.argument("key", required=False)
@shared_options
def help(key: str | None, overrides: tuple[str, ...], quiet: bool, log_format: str) -> None:
    """Say what a key, a column, a field, a figure or a file is.

    Keys of scenes and of summary.json, columns of tables, fields of results.vtkhdf: unit, default, bounds and meaning.
    Names that a run prints at its end are known as they stand there. Without a KEY, lists all keys of a scene.

    \b
    Example:
      knotfem help contact.friction
      knotfem help rods.0.mesh.element_length
      knotfem help steps.1.ends.rod.start.direction
      knotfem help unrest_N
      knotfem help verdict
      knotfem help jumps
    """
    from knotfem.reference import look_up, names, scene_keys

    printed = {spoken(name): name for name in names()}
    printed |= {words: name for said, name in printed.items() if " " in (words := said.partition(" [")[0])}
    text = "\n".join(found.path for found in scene_keys()) if key is None else look_up(printed.get(key, key))
    if log_format == "json":
        click.echo(json.dumps({"help": text}))
        return
    width = width_of()
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()))
        click.echo("\n".join(wrapped(line.strip(), width, indent)) if len(line) > (width or len(line)) else line)
