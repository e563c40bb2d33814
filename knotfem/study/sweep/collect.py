"""Figures of a run that a study collects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from knotfem.errors import KnotfemError
from knotfem.results.data import open_run
from knotfem.results.run import Run
from knotfem.run.directory import RunDirectory
from knotfem.run.knot_words import knot_said_in_one
from knotfem.scene.steps import Pull
from knotfem.study.sweep.study_file import Collected

Cell = float | int | str | bool | None
"""A figure, or None where the run has none."""
KNOTS = ("knot_before", "knot_after")
"""Keys of summary.json that have a record for each of several rods."""
JUDGED = ("verdict", "failure_mode")
"""What summary.json says of a run that was judged."""


def collect(directory: RunDirectory, wanted: Mapping[str, str | Collected]) -> dict[str, Cell]:
    """Figures by name, and the verdict; None where a run did not get so far.

    Args:
        directory: of a run that has ended, however it did.
        wanted: dotted keys of summary.json, or figures of tables, by name.
    """
    try:
        run = open_run(directory.path)
        summary = run.summary
    except KnotfemError:
        return dict.fromkeys((*JUDGED, *wanted))
    return {
        **{name: _plain(summary.get(name)) for name in JUDGED},
        **{name: _figure(run, summary, what) for name, what in wanted.items()},
    }


def _figure(run: Run, summary: Mapping[str, Any], what: str | Collected) -> Cell:
    if isinstance(what, str):
        found = _below(summary, what)
        return _plain(knot_said_in_one(found) if what in KNOTS else found)
    try:
        return _of_force(run, what) if what.table == "force" else _of_tension(run, what)
    except (KnotfemError, KeyError, IndexError, ValueError):
        return None


def _below(tables: Any, key: str) -> Any:
    """Value of a dotted key; names may have dots in them."""
    if not isinstance(tables, Mapping):
        return None
    if key in tables:
        return tables[key]
    parts = key.split(".")
    for cut in range(1, len(parts)):
        found = _below(tables.get(".".join(parts[:cut])), ".".join(parts[cut:]))
        if found is not None:
            return found
    return None


def _plain(value: Any) -> Cell:
    """A cell: a list or a table as text."""
    if value is None or isinstance(value, str | bool | int | float):
        return value
    return "; ".join(map(str, value)) if isinstance(value, list) else str(value)


def _of_force(run: Run, what: Collected) -> Cell:
    """A column of force.csv, between its rows at a displacement, or in the last one."""
    if what.column == "force_N" and what.at is not None:
        return float(run.force.at(what.at))
    table = run.table("force")
    if what.at is None:
        return float(table[what.column][-1])
    pulls = [step.name for step in run.scene.loading_steps if isinstance(step, Pull)]
    rows = np.isin(table["step"], pulls)
    went, values = table["displacement_mm"][rows], table[what.column][rows]
    if not went[0] <= what.at <= went[-1] * (1.0 + 1e-9):
        return None
    return float(np.interp(what.at, went, values))


def _of_tension(run: Run, what: Collected) -> Cell:
    """A column of tension.csv in the stored state next to a displacement: at a place along the rod, or over all."""
    table = run.tension(what.at).of(what.rod or run.scene.rods[0].name).table
    values = table[what.column]
    if what.s_over_L is not None:
        return float(np.interp(what.s_over_L, table["s_over_L"], values))
    return float({"max": np.max, "min": np.min, "mean": np.mean}[what.of](values))
