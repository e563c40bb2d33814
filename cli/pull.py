"""`knotfem pull`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from knotfem.errors import InputError
from knotfem_cli.common import (
    Verb,
    computing,
    force_option,
    from_option,
    last_option,
    model_option,
    new_run,
    open_run,
    output_option,
    shared_options,
    with_model,
)

if TYPE_CHECKING:
    from knotfem.run.directory import RunDirectory


@click.command(cls=Verb)
@click.argument("source", metavar="SCENE|RUN")
@output_option
@force_option
@model_option
@from_option
@last_option
@click.option("--accuracy", metavar="SHARE", help='Settings that were measured to reach it, such as "2%"; of a SCENE.')
@shared_options
def pull(
    source: str,
    output: Path | None,
    force: bool,
    model: str | None,
    from_run: str | None,
    last: bool,
    accuracy: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Pull the knot: force against displacement. Ties first what is not tied yet.

    A RUN goes on in its own directory or, with -o, as another run from the same tied knot, then with other steps,
    friction or effects if --set says so. Prints the run directory.

    \b
    Example:
      knotfem pull bowline
      knotfem tie bowline -o knot
      knotfem pull knot -o firm --set contact.friction=0.37
      knotfem pull bowline --accuracy 2%
      knotfem pull bowline --model rod
    """
    overrides, says = with_model(overrides, model, from_run, last), ""
    if accuracy is not None:
        from knotfem.study.accuracy import accurate_overrides

        overrides, says = accurate_overrides(source, overrides, accuracy)
    run = _prepare(source, output, force, overrides)
    from knotfem.run import driver

    with computing(run, quiet, log_format) as progress:
        if says:
            progress.message(says)
        driver.pull(run.scene, run, progress)


def _prepare(source: str, output: Path | None, force: bool, overrides: tuple[str, ...]) -> RunDirectory:
    from knotfem.run.directory import RunDirectory
    from knotfem.scene import load_scene
    from knotfem.shipped import scene_names

    shipped = source in scene_names() and not RunDirectory.is_run(source)
    if shipped or not Path(source).is_dir():
        return new_run(load_scene(source, overrides), output, force)
    if output is None:
        return open_run(source, overrides)
    run = RunDirectory.open(source)
    if output.resolve() == run.path.resolve():
        raise InputError("the run would replace its source", file=output, expected="another folder, or none with -o")
    scene = load_scene(run.scene_file, overrides)
    return run.branch(scene, output, force=force) if run.tied else new_run(scene, output, force)
