"""A cost table as CSV and on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from knotfem.cost.measured import COUNTS, PARTS, Measured
from knotfem.cost.quantities import LABELS
from knotfem.cost.study import TARGETS, Study

if TYPE_CHECKING:
    from rich.console import RenderableType

SHORT = {
    "force": "force",
    "force_end": "end force",
    "tension": "tension",
    "knot_size": "knot size",
    "sag": "sag",
    "shape": "shape",
    "penetration": "overlap/d",
}


def csv_columns(study: Study) -> dict[str, np.ndarray]:
    """Columns of cost.csv: a row a rung, errors relative, NaN where there is none."""
    front = {entry.rung.name for entry in study.front}
    rows = [
        {
            "rung": entry.rung.name,
            "ladder": entry.rung.ladder,
            "setting": entry.rung.setting,
            "size": entry.size if entry.size is not None else float("nan"),
            "state": entry.outcome.state,
            "reason": entry.outcome.reason,
            **{f"{part}_cpu_s": entry.cpu.get(part, float("nan")) for part in ("total", *PARTS)},
            **{f"{part}_wall_s": entry.wall.get(part, float("nan")) for part in ("total", *PARTS)},
            **{name: entry.counts.get(name, float("nan")) for name in COUNTS},
            **{f"{name}_error": study.error(entry, name) for name in study.references},
            **{f"{name}_own_error": study.own_error(entry, name) for name in study.references},
            "pareto": float(entry.rung.name in front),
        }
        for entry in study.measured
    ]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def tables(study: Study) -> list[RenderableType]:
    """What the terminal shows: errors and costs of rungs, limits of ladders, references."""
    return [_rungs(study), _limits(study), _references(study)]


def recommendations(study: Study) -> list[str]:
    """A sentence for each target, and one about what was left out."""
    label, lines = SHORT[study.main], []
    for target in TARGETS:
        entry = study.cheapest(target)
        if entry is None:
            lines.append(f"{target:.0%} in the {label}: no rung is that accurate within the reference's uncertainty")
            continue
        error = f"error {study.error(entry, study.main):.2%} +- {study.references[study.main][0].uncertainty:.2%}"
        cost = f"{entry.wall['total'] / 60.0:.1f} min here ({entry.cpu['total'] / 60.0:.1f} CPU min)"
        lines.append(f"{target:.0%} in the {label}: {entry.rung.name} ({entry.rung.setting}), {error}, about {cost}")
    missing = [f"{entry.rung.name} ({entry.outcome.state})" for entry in study.measured if not entry.done]
    if missing:
        lines.append(f"not in the table: {', '.join(missing)}")
    return lines


def _rungs(study: Study) -> RenderableType:
    from rich.table import Table

    names = list(study.references)
    table = Table(title=f"{study.scene.name}: errors in % against the reference, costs in CPU seconds")
    for column in ("rung", "setting", *(SHORT[name] for name in names), *(f"own {SHORT[study.main]}",)):
        table.add_column(column, justify="left" if column in ("rung", "setting") else "right")
    for column in ("wall", "CPU", *PARTS, "MB", "steps", "iterations"):
        table.add_column(column, justify="right")
    front = {entry.rung.name for entry in study.front}
    for entry in study.measured:
        if entry.outcome.state == "left out":
            continue
        mark = "* " if entry.rung.name in front else "  "
        if not entry.done:
            table.add_row(mark + entry.rung.name, f"{entry.rung.setting}: {_why(entry)}")
            continue
        errors = [_percent(study.error(entry, name)) for name in names] + [_percent(study.own_error(entry, study.main))]
        seconds = [f"{entry.wall['total']:.1f}", *(f"{entry.cpu[part]:.1f}" for part in ("total", *PARTS))]
        counts = [f"{entry.counts[name]:.0f}" for name in ("peak_memory_mb", "steps", "newton_iterations")]
        table.add_row(mark + entry.rung.name, entry.rung.setting, *errors, *seconds, *counts)
    table.caption = f"* on the Pareto front of CPU seconds and {LABELS[study.main]}"
    return table


def _limits(study: Study) -> RenderableType:
    from rich.table import Table

    table = Table(title="Limits of the ladders")
    for column in ("ladder", "quantity", "order", "limit", "uncertain by", "the sequence is"):
        table.add_column(column, justify="right" if column in ("order", "limit", "uncertain by") else "left")
    for name, limits in study.limits.items():
        for ladder, limit in limits.items():
            scale = study.references[name][0].scale
            order = "" if limit.order is None else f"{limit.order:.2f}"
            value = f"{limit.value[-1]:.5g}" if limit.value.size == 1 else ""
            table.add_row(ladder, LABELS[name], order, value, _percent(limit.uncertainty / scale) + " %", limit.verdict)
    return table


def _references(study: Study) -> RenderableType:
    from rich.table import Table

    table = Table(title="References: the first of each quantity is what errors are taken against")
    for column in ("quantity", "source", "value", "uncertain by", "from the first"):
        table.add_column(column, justify="left" if column in ("quantity", "source") else "right")
    for name, found in study.references.items():
        for reference in found:
            value = f"{reference.value[-1]:.5g}" if reference.value.size == 1 else ""
            apart = _percent(found[0].error(reference.value)) + " %" if reference is not found[0] else ""
            uncertain = _percent(reference.uncertainty) + " %"
            table.add_row(LABELS[name], reference.source, value, uncertain, apart)
    return table


def _percent(share: float) -> str:
    return "" if not np.isfinite(share) else f"{100.0 * share:.3g}"


def _why(entry: Measured) -> str:
    return f"{entry.outcome.state}, {entry.outcome.reason.splitlines()[0] if entry.outcome.reason else ''}"
