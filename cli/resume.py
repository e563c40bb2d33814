"""`knotfem resume`."""

from __future__ import annotations

import click

from knotfem_cli.common import Verb, computing, model_option, open_run, run_argument, shared_options, with_model


@click.command(cls=Verb)
@run_argument
@model_option
@shared_options
def resume(run: str, model: str | None, overrides: tuple[str, ...], quiet: bool, log_format: str) -> None:
    """Go on from a run's last checkpoint.

    The result is the same as if the run had never stopped. With --set, keys under solver and output may change.

    \b
    Example:
      knotfem resume runs/bowline-1
      knotfem resume runs/bowline-1 --set 'solver.time_limit=1 h'
    """
    directory = open_run(run, with_model(overrides, model))
    from knotfem.run import driver

    with computing(directory, quiet, log_format) as progress:
        driver.resume(directory, progress)
