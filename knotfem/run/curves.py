"""Force against displacement over all pulls of a run, and where a knot begins to lock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene.steps import Pull

LOCKING_SLOPE = 4.0
"""A knot begins to lock where the force rises this many times faster than it does in the middle of its first half."""


@dataclass(frozen=True, eq=False)
class Curve:
    """What a run's pulls have brought.

    Attributes:
        label: of the run.
        run: its folder.
        displacement: of the pulled end over all pulls [mm], ascending, shape [n].
        force: [N], shape [n].
        spans: first and last time [s] of each pull, and the displacement at which it set out [mm].
    """

    label: str
    run: RunDirectory
    displacement: np.ndarray
    force: np.ndarray
    spans: tuple[tuple[float, float, float], ...]

    def at(self, displacement: np.ndarray | float) -> np.ndarray:
        """Force at displacements within the curve [N]."""
        return np.asarray(np.interp(displacement, self.displacement, self.force))


def force_curve(run: RunDirectory, label: str) -> Curve:
    """Force against the displacement of all pulls of a run, one behind the other.

    Raises:
        InputError: the run has no pull yet.
    """
    path = run.path / "force.csv"
    table = read_table(path) if path.exists() else {}
    pulls = [step for step in run.scene.steps if isinstance(step, Pull)]
    displacement, force, spans, gone = [], [], [], 0.0
    for step in pulls:
        rows = table["step"] == step.name if table and table["time_s"].size else np.zeros(0, dtype=bool)
        if not rows.any():
            break
        displacement.append(gone + table["displacement_mm"][rows])
        force.append(table["force_N"][rows])
        end = float(table["time_s"][rows][-1])
        spans.append((end - float(table["displacement_mm"][rows][-1]) / step.speed, end, gone))
        gone += step.displacement
    if not displacement:
        raise InputError("no pull is stored", file=run.path, expected="a run that knotfem pull has brought on")
    return Curve(label, run, np.concatenate(displacement), np.concatenate(force), tuple(spans))


def onset_of_locking(displacement: np.ndarray, force: np.ndarray) -> float | None:
    """Displacement [mm] from which on the force rises `LOCKING_SLOPE` times faster than before, or None.

    Args:
        displacement: evenly spaced [mm], shape [n].
        force: [N], shape [n].
    """
    width = max(3, len(force) // 20)
    smooth = np.convolve(np.pad(force, width // 2, mode="edge"), np.full(width, 1.0 / width), mode="valid")[
        : len(force)
    ]
    slope = np.gradient(smooth, displacement)[width // 2 : -(width // 2)]
    limit = LOCKING_SLOPE * float(np.median(slope[: len(slope) // 2]))
    below = np.flatnonzero(slope < limit)
    if limit <= 0.0 or not below.size or below[-1] == len(slope) - 1:
        return None
    return float(displacement[width // 2 + below[-1] + 1])
