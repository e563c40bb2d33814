"""`knotfem sweep`."""

from __future__ import annotations

from pathlib import Path

import click

from knotfem_cli.common import (
    Verb,
    ask_if_long,
    engine_options,
    json_text,
    model_option,
    output_option,
    rope_option,
    shared_options,
    show_estimate,
    with_model,
    yes_option,
)


@click.command(cls=Verb, short_help="Run a scene at every combination of axes: one table.")
@click.argument("study", metavar="STUDY.toml", type=click.Path(path_type=Path))
@output_option
@engine_options
@click.option("--dry-run", is_flag=True, help="Say how many runs, hours and how much memory; run nothing.")
@model_option
@rope_option
@yes_option
@shared_options
def sweep(
    study: Path,
    output: Path | None,
    processes: int | None,
    scheduler: str | None,
    cluster: Path | None,
    dry_run: bool,
    model: str | None,
    rope: tuple[str, ...],
    yes: bool,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Run a scene at every combination of axes and collect the results in one table.

    STUDY.toml names the scene, the axes, what is set for all points and what is collected. Writes study.csv and a run
    directory for each point into the folder, studies/NAME by default, and prints the folder. The same command goes on
    with a study that was stopped or killed; so does the folder in place of the file. A point that fails is a result.

    \b
    Example:
      knotfem sweep friction.toml -o friction
      knotfem sweep friction.toml --dry-run
      knotfem sweep friction.toml --rope diameter="10 mm" youngs_modulus="5 MPa"
      knotfem sweep friction.toml --scheduler tcp://node1:8786
      knotfem sweep friction.toml --cluster slurm.toml
      knotfem sweep friction
    """
    from knotfem.scene.rope import rope_of
    from knotfem.study.engine.places import place_of
    from knotfem.study.progress import showing, study_progress
    from knotfem.study.sweep.plan import longest_hours
    from knotfem.study.sweep.run import planned_study

    chosen = with_model(overrides, model)
    place = place_of(processes, scheduler, cluster)
    wanted = planned_study(study, chosen, rope=rope_of(rope), out=output)
    for said in wanted.ropes if not quiet and log_format == "text" else ():
        click.echo(f"rope: {said}", err=True)
    found = wanted.cost(place)
    if dry_run:
        show_estimate(found, quiet, log_format)
        return
    ask_if_long(3600.0 * longest_hours(found), yes)
    with showing(study_progress(quiet=quiet, log_format=log_format)) as progress:
        table = wanted.run(place, progress)
    if log_format == "json":
        columns = {name: values.tolist() for name, values in table.columns.items()}
        click.echo(json_text({"folder": str(table.path), "points": columns}))
    else:
        click.echo(table.path)
