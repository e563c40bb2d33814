"""Results and costs of refinement levels, read from their run directories."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.results.data import open_run
from knotfem.results.run import Run
from knotfem.scene.model import Scene
from knotfem.study.engine.outcomes import Outcome
from knotfem.study.jobs import Jobs
from knotfem.study.quantities import Quantities, read_quantities
from knotfem.study.refinement import Level

PARTS = ("assembly", "contact", "factorisation", "solve", "output", "other")
"""What the time of a run went into; "other" is the rest: balances, knot names, step control."""
COUNTS = ("steps", "newton_iterations", "cutbacks", "dofs", "peak_memory_mb")


@dataclass(frozen=True, eq=False)
class Measured:
    """A level that is done, or what became of it.

    Attributes:
        level: what was run.
        scene: as the level has it; None where it is not done.
        outcome: whether it is done.
        quantities: what it came to; empty where it is not done.
        cpu: seconds by part, and "total".
        wall: likewise.
        counts: steps, newton_iterations, cutbacks, dofs, peak_memory_mb, loading_steps.
        effects: CPU seconds of each effect.
        size: what its error falls with; None where sizes say nothing.
    """

    level: Level
    scene: Scene | None
    outcome: Outcome
    quantities: Quantities = field(default_factory=dict)
    cpu: dict[str, float] = field(default_factory=dict)
    wall: dict[str, float] = field(default_factory=dict)
    counts: dict[str, float] = field(default_factory=dict)
    effects: dict[str, float] = field(default_factory=dict)
    size: float | None = None

    @property
    def done(self) -> bool:
        """Whether there are results."""
        return self.outcome.state == "done"


def measure(jobs: Jobs, level: Level) -> Measured:
    """Read what a level came to.

    Raises:
        InputError: a run that is done lacks its results.
    """
    outcome = jobs.outcomes[level.name]
    if outcome.state != "done":
        return Measured(level, None, outcome, size=level.size)
    run = open_run(jobs.run_of(level).path)
    summary = run.summary
    effects = {name: float(entry["cpu_s"]) for name, entry in summary["effects"].items()}
    return Measured(
        level,
        run.scene,
        outcome,
        read_quantities(run),
        _parts(summary, "cpu_s"),
        _parts(summary, "wall_s"),
        {name: float(summary.get(name, 0.0)) for name in COUNTS} | {"loading_steps": _loading_steps(run)},
        effects,
        level.size,
    )


def _parts(summary: dict, unit: str) -> dict[str, float]:
    phases, costs = summary["phases"], summary["costs"]
    total = float(sum(phase[unit] for phase in phases.values()))
    parts = {name: float(entry[unit]) for name, entry in costs.items()}
    parts["other"] = max(total - sum(parts.values()), 0.0)
    return {**{name: parts[name] for name in PARTS}, "total": total}


def _loading_steps(run: Run) -> float:
    return float(run.table("force")["time_s"].size)


def values_of(measured: list[Measured], name: str) -> np.ndarray:
    """One quantity of several levels, shape [levels, n]."""
    return np.stack([entry.quantities[name] for entry in measured])
