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
    from knotfem.verify.case import Case, Result


@click.command(cls=Verb, short_help="Compare this installation with closed-form solutions.")
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

    Prints case, quantity, expected value, found value, deviation, result and seconds; ends with code 4 when a check
    fails. -o writes the table as CSV, with sources and meshes, again after each case. The cases have settings of their
    own; no --set changes them. With --hard: whether each run finished, cutbacks, smallest J, penetration over the
    diameter, knot before and after, energy error, what else the case must satisfy, and wall seconds.

    \b
    Example:
      knotfem verify
      knotfem verify --only elastica --only torsion -o results.csv
      knotfem verify --hard --small
      knotfem verify --hard --only rough:overhand
    """
    from knotfem.verify.case import check, select

    if overrides:
        raise InputError("the cases have settings of their own", key="--set", found=overrides[0])
    if small and not hard:
        raise InputError("only hard cases have small versions", key="--small", expected="--hard --small")
    cases = select(_cases(hard, small), only)
    results: list[Result] = []
    told = not quiet and log_format == "text"
    _write(output, results)
    try:
        for number, case in enumerate(cases, start=1):
            if told:
                click.echo(f"{number}/{len(cases)} {case.name}: {case.title}", err=True)
            with _heeding_sigterm():
                results.append(check(case))
            _write(output, results)
            if log_format == "json":
                for row in results[-1].rows():
                    click.echo(json.dumps(row))
    finally:
        if told and results:
            _show(results, hard)
    if not all(result.passed for result in results):
        click.get_current_context().exit(4)


def _cases(hard: bool, small: bool) -> list[Case]:
    if hard:
        from knotfem.verify.stress.suite import hard_cases

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


def _write(output: Path | None, results: list[Result]) -> None:
    if output is not None:
        from knotfem.run.tables import write_table
        from knotfem.verify.case import table

        write_table(output, table(results))


def _show(results: list[Result], hard: bool) -> None:
    if hard:
        from knotfem.verify.stress.display import show
    else:
        from knotfem.verify.display import show
    show(results)
