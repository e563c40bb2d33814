"""`knotfem pull`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

import knotfem as kf
from knotfem.errors import InputError, NotConverged
from knotfem_cli.common import (
    Verb,
    ask_before,
    engine_options,
    force_option,
    from_option,
    last_option,
    model_option,
    output_option,
    progress_of,
    rope_option,
    scene_for,
    shared_options,
    show_run,
    with_model,
    yes_option,
)

if TYPE_CHECKING:
    from knotfem.scene.model import Scene


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
@click.option("--check", is_flag=True, help="With --accuracy: measure the error on this scene, refine until within it.")
@click.option("--budget", metavar="TIME", help='With --check: begin nothing that would end later, such as "1h".')
@engine_options
@rope_option
@yes_option
@shared_options
def pull(
    source: str,
    output: Path | None,
    force: bool,
    model: str | None,
    from_run: str | None,
    last: bool,
    accuracy: str | None,
    check: bool,
    budget: str | None,
    processes: int | None,
    scheduler: str | None,
    cluster: Path | None,
    rope: tuple[str, ...],
    yes: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Pull the knot: force against displacement. Ties first what is not tied yet.

    A RUN goes on in its own directory or, with -o, as another run from the same tied knot, then with other steps,
    friction or effects if --set says so. A name that is both a run in the working directory and a shipped scene means
    the run. Prints the run directory.

    With --check the error of the force curve is measured on the scene itself: each setting is refined in turn, and
    finer ones are taken until the error is within the accuracy. The runs are kept in RUN-check, and the same command
    goes on. Ends with exit code 4 where the budget ends before; the run is written all the same.

    \b
    Example:
      knotfem pull bowline
      knotfem tie bowline -o knot
      knotfem pull knot -o firm --set contact.friction=0.37
      knotfem pull bowline --rope diameter="10 mm" youngs_modulus="5 MPa" friction=0.25
      knotfem pull bowline --accuracy 2%
      knotfem pull figure-eight --model rod --accuracy 2% --check --budget 1h
      knotfem pull bowline --model rod
    """
    from knotfem.run.directory import RunDirectory

    chosen = with_model(overrides, model, from_run, last)
    if rope:
        _check_rope(source, accuracy)
    if check:
        from knotfem.study.progress import study_progress

        if accuracy is None:
            raise InputError("no accuracy", key="--check", expected='--accuracy, such as "2%"')
        checked = kf.check_accuracy(
            source,
            accuracy,
            chosen,
            out=output,
            budget=budget,
            force=force,
            jobs=processes,
            scheduler=scheduler,
            cluster=cluster,
            progress=study_progress(quiet=quiet, log_format=log_format),
        )
        show_checked(checked, quiet, log_format)
        return
    for option, value in (
        ("--budget", budget), ("--jobs", processes), ("--scheduler", scheduler), ("--cluster", cluster)
    ):  # fmt: skip
        if value is not None:
            raise InputError("only with --check", key=option, found=str(value), expected="--accuracy and --check too")
    progress = progress_of(quiet, log_format)
    if accuracy is not None:
        from knotfem.study.accuracy import accurate_overrides

        chosen, says = accurate_overrides(source, chosen, accuracy)
        progress.message(says)
    shadowed = RunDirectory.shadowed(source)
    if shadowed is not None:
        progress.message(shadowed)
    scene: Scene | Path
    if RunDirectory.means_run(source):
        scene = Path(source)
    else:
        scene, chosen = scene_for(source, chosen, rope), ()
        ask_before(scene, yes)
        if rope:
            progress.message(f"rope: {scene.rope}")
    run = kf.pull(
        scene,
        chosen,
        out=_folder(source, output),
        force=force,
        progress=progress,
    )
    show_run(run, quiet, log_format)


def show_checked(checked: kf.CheckedAccuracy, quiet: bool, log_format: str) -> None:
    """Say what was promised and what was measured.

    Raises:
        NotConverged: the target is not reached.
    """
    from rich.console import Console

    from knotfem.study.accuracy_check.report import table_of

    if log_format == "text" and not quiet:
        width = None if sys.stderr.isatty() else 120
        Console(width=width, stderr=True).print(table_of(checked))
    show_run(checked.run, quiet, log_format)
    if not checked.reached:
        raise NotConverged(str(checked))
    if log_format == "text":
        click.echo(str(checked), err=True)


def _check_rope(source: str, accuracy: str | None) -> None:
    from knotfem.run.directory import RunDirectory

    if RunDirectory.is_run(source):
        raise InputError("a run has its rope", key="--rope", found=source, expected="a scene")
    if accuracy is not None:
        expected = "a scene that knotfem check --rope ... -o FILE.toml has written"
        raise InputError("not with --accuracy", key="--rope", expected=expected)


def _folder(source: str, output: Path | None) -> Path | bool:
    """Where the run goes: a run goes on in its own folder if no other is named."""
    from knotfem.run.directory import RunDirectory

    if not RunDirectory.is_run(source):
        return output or True
    if output is not None and output.resolve() == Path(source).resolve():
        raise InputError("the run would replace its source", file=output, expected="another folder, or none with -o")
    return output or Path(source)
