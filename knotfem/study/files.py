"""What a study leaves in its folder: cost.csv, cost.png, recommendation.json, effects.csv."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.files import write_json
from knotfem.run.tables import write_table
from knotfem.study.convergence import ConvergenceStudy
from knotfem.study.measured import Measured
from knotfem.study.quantities import LABELS
from knotfem.study.records import record_of
from knotfem.study.references import falling
from knotfem.study.refinement import SIZED
from knotfem.study.switches import EffectsStudy, effects_rows
from knotfem.study.tables import level_rows


def write_study(study: ConvergenceStudy, folder: Path) -> dict[str, Path | None]:
    """Write table, plot and, where it has a bounded reference, the recommendation; else remove an older one.

    Returns:
        The files by what they are.

    Raises:
        InputError: nothing can be written there.
    """
    table, picture, recommendation = (folder / name for name in ("cost.csv", "cost.png", "recommendation.json"))
    write_table(table, _columns(level_rows(study)))
    if study.bounded:
        write_json(recommendation, asdict(record_of(study)))
    else:
        recommendation.unlink(missing_ok=True)
    plot(study, picture)
    return {"table": table, "picture": picture, "recommendation": recommendation if study.bounded else None}


def write_effects(study: EffectsStudy, folder: Path) -> Path:
    """Write effects.csv, return its path.

    Raises:
        InputError: nothing can be written there.
    """
    table = folder / "effects.csv"
    write_table(table, _columns(effects_rows(study)))
    return table


def _columns(rows: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def plot(study: ConvergenceStudy, out: Path) -> None:
    """Draw the error in the main quantity against CPU seconds, series by series, the Pareto front marked."""
    from knotfem.plot.pareto import plot_pareto

    def points(entries: Sequence[Measured]) -> list[tuple[float, float]]:
        found = [(entry.cpu["total"], study.error(entry, study.main)) for entry in entries if entry.done]
        return [(cpu, error) for cpu, error in found if error > 0.0]

    series = {
        name: points(falling(entries) if name in SIZED else [entry for entry in entries if entry.level.series == name])
        for name, entries in study.series.items()
    }
    front = [(*point, study.error_bound(entry)) for entry in study.front for point in points([entry])]
    plot_pareto(
        series,
        front,
        out,
        label=LABELS[study.main],
        uncertainty=study.references[study.main][0].uncertainty if study.bounded else 0.0,
        unordered=[name for name in study.series if name not in SIZED],
        title=study.scene.name,
    )
