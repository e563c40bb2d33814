"""`knotfem pull`."""

from __future__ import annotations

from pathlib import Path

import click

import knotfem as kf
from knotfem.errors import InputError
from knotfem_cli.common import (
    Verb,
    force_option,
    from_option,
    last_option,
    model_option,
    output_option,
    progress_of,
    shared_options,
    show_run,
    with_model,
)


@click.command(cls=Verb)
@click.argument("source", metavar="SCENE|RUN")
@output_option
@force_option
@model_option
@from_option
@last_option
@click.option(
    "--accuracy", metavar="FRACTION", help='Settings that were measured to reach it, such as "2%"; of a SCENE.'
)
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
    friction or effects if --set says so. A name that is both a run in the working directory and a shipped scene means
    the run. Prints the run directory.

    \b
    Example:
      knotfem pull bowline
      knotfem tie bowline -o knot
      knotfem pull knot -o firm --set contact.friction=0.37
      knotfem pull bowline --accuracy 2%
      knotfem pull bowline --model rod
    """
    from knotfem.run.directory import RunDirectory

    chosen, progress = with_model(overrides, model, from_run, last), progress_of(quiet, log_format)
    if accuracy is not None:
        from knotfem.study.accuracy import accurate_overrides

        chosen, says = accurate_overrides(source, chosen, accuracy)
        progress.message(says)
    shadowed = RunDirectory.shadowed(source)
    if shadowed is not None:
        progress.message(shadowed)
    run = kf.pull(
        source if shadowed is None else Path(source),
        chosen,
        out=_folder(source, output),
        force=force,
        progress=progress,
    )
    show_run(run, quiet, log_format)


def _folder(source: str, output: Path | None) -> Path | bool:
    """Where the run goes: a run goes on in its own folder if no other is named."""
    from knotfem.run.directory import RunDirectory

    if not RunDirectory.is_run(source):
        return output or True
    if output is not None and output.resolve() == Path(source).resolve():
        raise InputError("the run would replace its source", file=output, expected="another folder, or none with -o")
    return output or Path(source)
