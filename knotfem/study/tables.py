"""A convergence study as rows of a table and on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from knotfem.study.convergence import TARGETS, ConvergenceStudy
from knotfem.study.measured import COUNTS, PARTS, Measured
from knotfem.study.quantities import LABELS

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

SHORT = {
    "force": "force",
    "force_end": "end force",
    "tension": "tension",
    "knot_size": "knot size",
    "sag": "sag",
    "shape": "shape",
    "penetration": "overlap/d",
}


def level_rows(study: ConvergenceStudy) -> list[dict[str, Any]]:
    """Rows of cost.csv, one for each level: errors relative, NaN where there is none; scripts read its names."""
    front = {entry.level.name for entry in study.front}
    return [
        {
            "rung": entry.level.name,
            "ladder": entry.level.series,
            "setting": entry.level.setting,
            "size": entry.size if entry.size is not None else float("nan"),
            "state": entry.outcome.state,
            "reason": entry.outcome.reason,
            **{f"{part}_cpu_s": entry.cpu.get(part, float("nan")) for part in ("total", *PARTS)},
            **{f"{part}_wall_s": entry.wall.get(part, float("nan")) for part in ("total", *PARTS)},
            **{name: entry.counts.get(name, float("nan")) for name in COUNTS},
            **{f"{name}_error": study.error(entry, name) for name in study.references},
            **{f"{name}_own_error": study.own_error(entry, name) for name in study.references},
            "trusted_error": study.error_bound(entry),
            "pareto": float(entry.level.name in front),
        }
        for entry in study.measured
    ]


def reference_rows(study: ConvergenceStudy) -> dict[str, list[dict[str, Any]]]:
    """References by quantity, the least uncertain first: source, value (of a curve its end), relative uncertainty."""
    return {
        name: [{"source": one.source, "value": one.value[-1], "uncertainty": one.uncertainty} for one in found]
        for name, found in study.references.items()
    }


def tables(study: ConvergenceStudy) -> list[RenderableType]:
    """What the terminal shows: errors of levels, their costs, limits of refinement series, references."""
    return [_errors(study), _costs(study), _limits(study), _references(study)]


def recommendations(study: ConvergenceStudy) -> list[str]:
    """A sentence for each target, and one about what was left out."""
    label, lines = SHORT[study.main], []
    if not study.bounded:
        return [f"nothing is recommended: {_unbounded(study)}", *_missing(study)]
    for target in TARGETS:
        entry = study.cheapest(target)
        if entry is None:
            lines.append(f"{target:.0%} in the {label}: no level is that accurate within the reference's uncertainty")
            continue
        uncertainty = study.references[study.main][0].uncertainty
        error = f"error {_percent(study.error_bound(entry))} +- {_percent(uncertainty)} %"
        cost = f"{duration(entry.wall['total'])} here ({duration(entry.cpu['total'])} of CPU time)"
        lines.append(f"{target:.0%} in the {label}: {entry.level.name} ({entry.level.setting}), {error}, about {cost}")
    return [*lines, *_missing(study)]


def _unbounded(study: ConvergenceStudy) -> str:
    found = study.references[study.main]
    if not found:
        return "no refinement series gives a reference"
    return f"the reference lacks {', '.join(found[0].lacks)}; run these series too, or uniform"


def _missing(study: ConvergenceStudy) -> list[str]:
    missing = [f"{entry.level.name} ({entry.outcome.state})" for entry in study.measured if not entry.done]
    return [f"not in the table: {', '.join(missing)}"] if missing else []


def _errors(study: ConvergenceStudy) -> RenderableType:
    names = list(study.references)
    table = _table(
        f"{study.scene.name}: errors in % against the reference",
        ("", "level", "setting"),
        (*(SHORT[name] for name in names), f"own {SHORT[study.main]}", "bound", "CPU"),
        f"* on the Pareto front of CPU seconds and {LABELS[study.main]}; bound: the largest error of all finer levels",
    )
    front = {entry.level.name for entry in study.front}
    for entry in study.measured:
        mark = "*" if entry.level.name in front else ""
        if entry.done:
            errors = [_percent(study.error(entry, name)) for name in names]
            own, bound = _percent(study.own_error(entry, study.main)), _percent(study.error_bound(entry))
            cpu = duration(entry.cpu["total"])
            table.add_row(mark, entry.level.name, entry.level.setting, *errors, own, bound, cpu)
        elif entry.outcome.state != "left out":
            table.add_row(mark, entry.level.name, _why(entry))
    return table


def _costs(study: ConvergenceStudy) -> RenderableType:
    table = _table(
        "Costs: wall seconds, CPU seconds in all and by part",
        ("level",),
        ("wall", "CPU", *PARTS, "MB", "steps", "iter."),
    )
    for entry in study.measured:
        if entry.done:
            seconds = [f"{entry.wall['total']:.1f}", *(f"{entry.cpu[part]:.1f}" for part in ("total", *PARTS))]
            counts = [f"{entry.counts[name]:.0f}" for name in ("peak_memory_mb", "steps", "newton_iterations")]
            table.add_row(entry.level.name, *seconds, *counts)
    return table


def _limits(study: ConvergenceStudy) -> RenderableType:
    table = _table(
        "Limits of the refinement series", ("series", "quantity", "sequence"), ("order", "limit", "uncertain by")
    )
    for name, limits in study.limits.items():
        for series, limit in limits.items():
            scale = study.references[name][0].scale
            order = "" if limit.order is None else f"{limit.order:.2f}"
            value = f"{limit.value[-1]:.5g}" if limit.value.size == 1 else ""
            uncertain = _percent(limit.uncertainty / scale) + " %"
            table.add_row(series, SHORT[name], limit.behaviour, order, value, uncertain)
    return table


def _references(study: ConvergenceStudy) -> RenderableType:
    table = _table(
        "References: errors are taken against the first of each quantity",
        ("quantity", "source"),
        ("value", "uncertain by", "from the first"),
    )
    for name, found in study.references.items():
        for reference in found:
            value = f"{reference.value[-1]:.5g}" if reference.value.size == 1 else ""
            apart = _percent(found[0].error(reference.value)) + " %" if reference is not found[0] else ""
            uncertain = "no bound" if reference.lacks else _percent(reference.uncertainty) + " %"
            table.add_row(SHORT[name], reference.source, value, uncertain, apart)
    return table


def _table(title: str, texts: Sequence[str], numbers: Sequence[str], caption: str | None = None) -> Table:
    """A table whose level names and numbers are never cut."""
    from rich import box
    from rich.table import Table

    table = Table(title=title, caption=caption, box=box.SIMPLE, padding=(0, 1), title_justify="left")
    for column in texts:
        table.add_column(column, no_wrap=column in ("", "level"))
    for column in numbers:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _percent(fraction: float) -> str:
    return "" if not np.isfinite(fraction) else f"{100.0 * fraction:.2g}"


def duration(seconds: float) -> str:
    """Seconds or minutes, for people."""
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


def _why(entry: Measured) -> str:
    return f"{entry.outcome.state}, {entry.outcome.reason.splitlines()[0] if entry.outcome.reason else ''}"
