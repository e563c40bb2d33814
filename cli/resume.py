"""`knotfem resume`."""

from __future__ import annotations

from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import Verb, model_option, progress_of, run_argument, shared_options, show_run, with_model


@click.command(cls=Verb)
@run_argument
@model_option
@shared_options
def resume(run: Path, model: str | None, overrides: tuple[str, ...], quiet: bool, log_format: str) -> None:
    """Go on from a run's last checkpoint.

    The result is the same as if the run had never stopped. With --set, keys under solver and output may change.

    \b
    Example:
      knotfem resume runs/bowline-1
      knotfem resume runs/bowline-1 --set 'solver.time_limit=1 h'
    """
    done = kf.resume(run, with_model(overrides, model), progress=progress_of(quiet, log_format))
    show_run(done, quiet, log_format)
