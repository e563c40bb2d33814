"""`knotfem tie`."""

from __future__ import annotations

from pathlib import Path

import click

import knotfem as kf
from knotfem_cli.common import (
    Verb,
    ask_before,
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


@click.command(cls=Verb)
@click.argument("scene")
@output_option
@force_option
@model_option
@from_option
@last_option
@click.option(
    "--path",
    "tie_path",
    type=click.Choice(["polynomial", "linear", "inextensible", "direct"]),
    help="The mapping; as the scene says by default.",
)
@rope_option
@yes_option
@shared_options
def tie(
    scene: str,
    output: Path | None,
    force: bool,
    model: str | None,
    from_run: str | None,
    last: bool,
    tie_path: str | None,
    rope: tuple[str, ...],
    yes: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Tie the knot by mapping its centreline.

    Ends with the loose knot in equilibrium, contact on. SCENE is a TOML file or a shipped name. Prints the run
    directory.

    \b
    Example:
      knotfem tie bowline -o knot
      knotfem tie bowline --path linear
      knotfem tie bowline --rope diameter="10 mm" friction=0.25
      knotfem tie bowline --model rod --from knot -o light
    """
    chosen = overrides if tie_path is None else (*overrides, f"tie.path={tie_path}")
    progress = progress_of(quiet, log_format)
    chosen = with_model(chosen, model, from_run, last)
    source = scene_for(scene, chosen, rope)
    if rope:
        progress.message(f"rope: {source.rope}")
    ask_before(source.model_copy(update={"steps": source.tying_steps}), yes)
    run = kf.tie(source, out=output or True, force=force, progress=progress)
    show_run(run, quiet, log_format)
