"""`knotfem doctor`."""

from __future__ import annotations

import json

import click

from knotfem_cli.common import Verb, shared_options
from knotfem_cli.text import facts, width_of


@click.command(cls=Verb)
@shared_options
def doctor(overrides: tuple[str, ...], quiet: bool, log_format: str) -> None:
    """Say what this machine has.

    Libraries, linear solvers, OpenGL, threads. With --set solver.linear, fails if this machine does not have that
    solver. With --quiet, nothing but the exit code.

    \b
    Example:
      knotfem doctor
      knotfem doctor --set solver.linear=pardiso
    """
    from knotfem.doctor import describe, require
    from knotfem.scene import load_scene

    require(load_scene("cantilever", overrides).solver)
    found = describe()
    if log_format == "json":
        click.echo(json.dumps(found))
    elif not quiet:
        click.echo(facts(found, width=width_of()))
