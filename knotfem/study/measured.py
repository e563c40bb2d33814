"""What rungs came to and what they cost, read from their run directories."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from knotfem.run.directory import RunDirectory
from knotfem.run.tables import read_table
from knotfem.scene.model import Scene
from knotfem.study.campaign import Campaign, Outcome
from knotfem.study.ladders import Rung
from knotfem.study.quantities import Quantities, read_quantities

PARTS = ("assembly", "contact", "factorisation", "solve", "output", "other")
"""What the time of a run went into; "other" is the rest: balances, knot names, step control."""
COUNTS = ("steps", "newton_iterations", "cutbacks", "dofs", "peak_memory_mb")


@dataclass(frozen=True, eq=False)
class Measured:
    """A rung that is done, or what became of it.

    Attributes:
        rung: what was run.
        scene: as the rung has it; None where it is not done.
        outcome: whether it is done.
        quantities: what it came to; empty where it is not done.
        cpu: seconds by part, and "total".
        wall: likewise.
        counts: steps, newton_iterations, cutbacks, dofs, peak_memory_mb, loading_steps.
        effects: CPU seconds of each effect.
        size: what its error falls with; None where sizes say nothing.
    """

    rung: Rung
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


def measure(campaign: Campaign, rung: Rung) -> Measured:
    """Read what a rung came to.

    Raises:
        InputError: a run that is done lacks its results.
    """
    outcome = campaign.outcomes[rung.name]
    if outcome.state != "done":
        return Measured(rung, None, outcome, size=rung.size)
    run = campaign.run_of(rung)
    summary = run.read_summary()
    effects = {name: float(entry["cpu_s"]) for name, entry in summary["effects"].items()}
    return Measured(
        rung,
        run.scene,
        outcome,
        read_quantities(run),
        _parts(summary, "cpu_s"),
        _parts(summary, "wall_s"),
        {name: float(summary.get(name, 0.0)) for name in COUNTS} | {"loading_steps": _loading_steps(run)},
        effects,
        rung.size,
    )


def _parts(summary: dict, unit: str) -> dict[str, float]:
    phases, costs = summary["phases"], summary["costs"]
    total = float(sum(phase[unit] for phase in phases.values()))
    parts = {name: float(entry[unit]) for name, entry in costs.items()}
    parts["other"] = max(total - sum(parts.values()), 0.0)
    return {**{name: parts[name] for name in PARTS}, "total": total}


def _loading_steps(run: RunDirectory) -> float:
    return float(len(read_table(run.path / "force.csv")["time_s"]))


def values_of(measured: list[Measured], name: str) -> np.ndarray:
    """One quantity of several rungs, shape [rungs, n]."""
    return np.stack([entry.quantities[name] for entry in measured])
