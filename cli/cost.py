"""`knotfem cost`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import click

from knotfem_cli.common import Verb, engine_options, json_text, model_option, output_option, shared_options, with_model


@click.command(cls=Verb)
@click.argument("scene")
@output_option
@click.option("--budget", metavar="TIME", help='Start nothing that would end later, such as "20min".')
@click.option("--series", "--ladder", "series", metavar="NAME", multiple=True, help="Only this choice; repeatable.")
@engine_options
@click.option("--effects", is_flag=True, help="Switch each effect off in turn instead.")
@click.option("--store", type=click.Path(path_type=Path), is_flag=False, flag_value=Path(), metavar="[FILE]",
              help="Keep the recommendation for --accuracy: in a file, or for this user.")  # fmt: skip
@model_option
@shared_options
def cost(
    scene: str,
    output: Path | None,
    budget: str | None,
    series: tuple[str, ...],
    processes: int | None,
    scheduler: str | None,
    cluster: Path | None,
    effects: bool,
    store: Path | None,
    model: str | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Measure what accuracy costs in time.

    Runs a refinement series for every choice that trades one for the other: section, slice, step, penalty, ramp,
    tolerance, sampling, stick, uniform (all at once), element, model, and combinations that follow from them (chosen).
    Runs are kept in the folder; the same command goes on where it was stopped. Writes cost.csv, cost.png and
    recommendation.json.

    \b
    Example:
      knotfem cost cantilever --budget 10min
      knotfem cost bowline --series slice --series section --set 'steps.1.displacement=30 mm' -o cost-bowline
      knotfem cost bowline --effects -o cost-bowline
    """
    from rich.console import Console

    from knotfem.errors import InputError
    from knotfem.scene import load_scene
    from knotfem.scene.quantity import DURATION, parse_quantity
    from knotfem.study import convergence, files, records, switches, tables
    from knotfem.study.engine.places import place_of, whole_machine

    for option, given in (("--store", store is not None), ("--series", bool(series))):
        if effects and given:
            raise InputError("not with --effects", key=option, expected="either of the two")
    chosen = with_model(overrides, model)
    folder = output or Path("costs") / load_scene(scene, chosen).name
    place = whole_machine(place_of(processes, scheduler, cluster))
    seconds = parse_quantity(budget, DURATION, "--budget") if budget is not None else None

    def tell(text: str) -> None:
        if not quiet:
            click.echo(json.dumps({"message": text}) if log_format == "json" else text, err=True)

    width = None if sys.stdout.isatty() else 160
    console = Console(width=width, quiet=quiet or log_format == "json")
    if effects:
        switched = switches.run_effects(scene, chosen, folder, budget=seconds, place=place, tell=tell)
        result = {"table": files.write_effects(switched, folder), "effects": switches.effects_rows(switched)}
        console.print(switches.effects_table(switched))
    else:
        found = convergence.run_convergence(scene, chosen, folder, budget=seconds, names=series, place=place, tell=tell)
        result = {
            **files.write_study(found, folder),
            "rungs": tables.level_rows(found),
            "references": tables.reference_rows(found),
            "recommendations": tables.recommendations(found),
        }
        console.print(*tables.tables(found), *result["recommendations"], sep="\n")
        if store is not None:
            result["stored"] = records.user_file() if store == Path() else store
            replaced = records.store(records.record_of(found), result["stored"])
            older = f", in place of what was measured on {replaced.scene} on {replaced.date}" if replaced else ""
            tell(f"stored for --accuracy in {result['stored']}{older}")
    click.echo(json_text({"folder": folder, **result}) if log_format == "json" else folder)
