"""`knotfem verify`."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

import click

from knotfem.errors import InputError, Stopped
from knotfem_cli.common import Verb, output_option, shared_options

if TYPE_CHECKING:
    from knotfem.verify.verdict import Case, Verdict


@click.command(cls=Verb)
@click.option("--only", metavar="NAME", multiple=True, help="A case of the table, or a group of them; repeatable.")
@click.option("--hard", is_flag=True, help="The hard cases instead of the closed forms; hours.")
@click.option("--small", is_flag=True, help="With --hard: their small versions; minutes.")
@output_option
@shared_options
def verify(
    only: tuple[str, ...],
    hard: bool,
    small: bool,
    output: Path | None,
    overrides: tuple[str, ...],
    quiet: bool,
    log_format: str,
) -> None:
    """Compare this installation with closed-form solutions, or run the hard cases.

    Prints case, quantity, expected value, found value, deviation, verdict and seconds; ends with code 4 when a
    verdict fails. -o writes the table as CSV, with sources and meshes, anew after each case. The cases have settings
    of their own; no --set changes them. With --hard: whether each run finished, cutbacks, smallest J, penetration over
    the diameter, knot before and after, energy error, what the case must besides, and wall seconds.

    \b
    Example:
      knotfem verify
      knotfem verify --only elastica --only torsion -o verdicts.csv
      knotfem verify --hard --small
      knotfem verify --hard --only rough:overhand
    """
    from knotfem.verify.verdict import judge, select

    if overrides:
        raise InputError("the cases have settings of their own", key="--set", found=overrides[0])
    if small and not hard:
        raise InputError("only hard cases have small versions", key="--small", expected="--hard --small")
    cases = select(_cases(hard, small), only)
    verdicts: list[Verdict] = []
    told = not quiet and log_format == "text"
    _write(output, verdicts)
    try:
        for number, case in enumerate(cases, start=1):
            if told:
                click.echo(f"{number}/{len(cases)} {case.name}: {case.title}", err=True)
            with _heeding_sigterm():
                verdicts.append(judge(case))
            _write(output, verdicts)
            if log_format == "json":
                for row in verdicts[-1].rows():
                    click.echo(json.dumps(row))
    finally:
        if told and verdicts:
            _show(verdicts, hard)
    if not all(verdict.passed for verdict in verdicts):
        click.get_current_context().exit(4)


def _cases(hard: bool, small: bool) -> list[Case]:
    if hard:
        from knotfem.verify.stress.cases import hard_cases

        return hard_cases(small=small)
    from knotfem.verify.suite import closed_forms

    return closed_forms()


@contextmanager
def _heeding_sigterm() -> Iterator[None]:
    """SIGTERM stops a case wherever it is; a run that can end in order takes the signal over."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Stopped("asked to stop")

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _write(output: Path | None, verdicts: list[Verdict]) -> None:
    if output is not None:
        from knotfem.run.tables import write_table
        from knotfem.verify.verdict import table

        write_table(output, table(verdicts))


def _show(verdicts: list[Verdict], hard: bool) -> None:
    if hard:
        from knotfem.verify.stress.display import show
    else:
        from knotfem.verify.display import show
    show(verdicts)
