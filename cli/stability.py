"""`knotfem stability`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from knotfem_cli.common import (
    Verb,
    ask_if_long,
    engine_options,
    json_text,
    numbers,
    output_option,
    rope_option,
    scene_for,
    shared_options,
    show_estimate,
    yes_option,
)


@click.command(cls=Verb)
@click.argument("scene")
@output_option
@click.option("--friction", metavar="NUMBERS", help='Coefficients, such as "0.1, 0.15" or "0:0.4:9" (the default).')
@click.option("--x", metavar="NUMBERS", help='B/(T0 r^2), "5, 6, 7.4, 9.1, 13.9, 25" by default.')
@click.option("--load", metavar="FORCES", help='T0 instead of x, such as "0.5 N, 2 N".')
@click.option("--model", "models", type=click.Choice(["fem", "rod"]), multiple=True,
              help="Hexahedra or discrete rods; repeatable, drawn over each other.")  # fmt: skip
@click.option("--boundary", type=float, is_flag=False, flag_value=0.01, metavar="[WIDTH]",
              help="Find the boundary by bisection, to 0.01 unless told otherwise.")  # fmt: skip
@click.option("--lowered", is_flag=True, help="Find it by friction that falls, too.")
@click.option("--no-grid", is_flag=True, help="Only the boundary, between the smallest and the largest friction.")
@click.option("--free-load", type=float, default=0.05, show_default=True, help="Load on a free end over T0.")
@click.option("--direction", metavar="X,Y,Z", help="Of the load on the free ends; opposite to T0 by default.")
@click.option("--ramp", metavar="TIME", help='T0 rises from 0, such as "10 s"; at once by default.')
@click.option("--overlay", type=click.Path(path_type=Path), multiple=True, metavar="FOLDER",
              help="Another stability study whose boundaries are drawn, too; repeatable.")  # fmt: skip
@click.option("--dry-run", is_flag=True, help="Say how many runs and hours; run nothing.")
@rope_option
@yes_option
@engine_options
@shared_options
def stability(
    scene: str,
    output: Path | None,
    friction: str | None,
    x: str | None,
    load: str | None,
    models: tuple[str, ...],
    boundary: float | None,
    lowered: bool,
    no_grid: bool,
    free_load: float,
    direction: str | None,
    ramp: str | None,
    overlay: tuple[Path, ...],
    dry_run: bool,
    rope: tuple[str, ...],
    yes: bool,
    processes: int | None,
    scheduler: str | None,
    cluster: Path | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Find for which friction and load a knot holds.

    Each point is a knot that comes to rest, bears T0 = B/(x r^2) with its free ends held, and then has them let go
    under a small load, until it is at rest or has unravelled. The grid is that of the paper, 54 points, unless told
    otherwise. Writes study.csv, boundary.csv, stability.png and, for a bowline, fit.json into the folder,
    stability/NAME by default, and prints the folder. The same command goes on with a study that was stopped.

    \b
    Example:
      knotfem stability bowline --model rod
      knotfem stability bowline --model rod --no-grid --boundary --lowered -o boundary
      knotfem stability clove-hitch --model rod --x 10,20,40 --boundary 0.02
      knotfem stability clove-hitch --model rod --load "0.5 N, 2 N"
      knotfem stability bowline --model rod --rope diameter="10 mm" obstacle_friction=0.3
    """
    from knotfem.study.dead_load import free_directions
    from knotfem.study.engine.places import place_of
    from knotfem.study.progress import showing, study_progress
    from knotfem.study.stability.diagram import PICTURE, open_stability
    from knotfem.study.stability.grid import FRICTION
    from knotfem.study.stability.run import asked_of
    from knotfem.study.sweep.plan import longest_hours

    source = scene_for(scene, overrides, rope)
    if rope and not quiet and log_format == "text":
        click.echo(f"rope: {source.rope}", err=True)
    given = {
        "friction": FRICTION if friction is None else numbers(friction, "--friction"),
        "x": None if x is None else numbers(x, "--x"),
        "load": None if load is None else [force.strip() for force in load.split(",")],
        "models": models,
        "grid": not no_grid,
        "boundary": boundary,
        "lowered": lowered,
        "free_load": free_load,
        "ramp": ramp,
    }
    if direction is not None:
        given["free"] = free_directions(source, (), numbers(direction, "--direction"))
    asked = asked_of(source, (), loaded=None, out=output, **{"free": None, **given})
    place = place_of(processes, scheduler, cluster)
    found = asked.cost(place)
    if dry_run:
        show_estimate(found, quiet, log_format)
        return
    ask_if_long(3600.0 * longest_hours(found), yes)
    others = {name: open_stability(folder) for name, folder in named(overlay).items()}
    with showing(study_progress(quiet=quiet, log_format=log_format)) as progress:
        diagram = asked.run(place, progress)
    if others:
        diagram.plot(diagram.path / PICTURE, others)
    if log_format == "json":
        rows = {name: values.tolist() for name, values in diagram.boundary.items()}
        fits = diagram.fits() if diagram.bowline else {}
        click.echo(json_text({"folder": diagram.path, "boundary": rows, "fits": fits}))
        return
    if not quiet:
        click.echo(diagram.text(), err=True)
    click.echo(diagram.path)


def named(folders: Sequence[Path]) -> dict[str, Path]:
    """Folders by their names, where two have the same name by their paths."""
    names = [folder.name for folder in folders]
    return {str(folder) if names.count(folder.name) > 1 else folder.name: folder for folder in folders}
