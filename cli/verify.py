"""`knotfem verify`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from knotfem_cli.common import Verb, output_option, shared_options


@click.command(cls=Verb)
@click.option("--only", metavar="NAME", multiple=True, help="A case of the table, or a group of them; repeatable.")
@output_option
@shared_options
def verify(
    only: tuple[str, ...], output: Path | None, overrides: tuple[str, ...], quiet: bool, log_format: str
) -> None:
    """Compare this installation with closed-form solutions.

    Prints case, quantity, expected value, found value, deviation, verdict and seconds; ends with code 4 when a
    verdict fails. -o writes the table as CSV, with sources and meshes. The cases have settings of their own; no --set
    changes them.

    \b
    Example:
      knotfem verify
      knotfem verify --only elastica --only torsion -o verdicts.csv
    """
    from knotfem.errors import InputError
    from knotfem.verify.suite import closed_forms
    from knotfem.verify.verdict import judge, select, table

    if overrides:
        raise InputError("closed forms have settings of their own", key="--set", found=overrides[0])
    cases = select(closed_forms(), only)
    verdicts = []
    for number, case in enumerate(cases, start=1):
        if not quiet and log_format == "text":
            click.echo(f"{number}/{len(cases)} {case.name}: {case.title}", err=True)
        verdicts.append(judge(case))
        if log_format == "json":
            for row in verdicts[-1].rows():
                click.echo(json.dumps(row))
    if output is not None:
        from knotfem.run.tables import write_table

        write_table(output, table(verdicts))
    if not quiet and log_format == "text":
        from knotfem.verify.display import show

        show(verdicts)
    if not all(verdict.passed for verdict in verdicts):
        click.get_current_context().exit(4)
