"""What came of a run of a hard case, and the limits that every run must keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.scene import Scene
from knotfem.verify.case import Kind, Quantity

Table = Mapping[str, np.ndarray]

FEW_CUTBACKS, CUTBACKS = 3.0, 0.5
"""Rejected attempts that are always allowed, and the fraction of the steps that is."""
SMALLEST_J = 0.05
PENETRATION = 0.10
"""Deepest penetration over the diameter."""
ENERGY = 0.02
"""Largest error of the energy balance over the energy put in."""


@dataclass(frozen=True)
class Outcome:
    """What came of a run.

    Attributes:
        ended: "yes", or the error that ended it.
        steps: accepted.
        cutbacks: rejected attempts at a step.
        jacobian: smallest determinant of the deformation gradient.
        penetration: deepest, over the diameter.
        before: knot with which the steps set out; "" where there was none yet.
        after: knot at the end.
        energy_error: largest error of the energy balance over the energy put in; None where nothing was loaded.
        scene: what was run.
        iterations: of Newton's method.
        force: columns of the table of forces.
        tension: columns of the table of tension profiles.
        log: records of all steps.
    """

    ended: str
    steps: int
    cutbacks: int
    jacobian: float
    penetration: float
    before: str
    after: str
    energy_error: float | None
    scene: Scene
    iterations: int
    force: Table
    tension: Table
    log: Sequence[Mapping[str, Any]]

    @property
    def finished(self) -> bool:
        """Whether the run reached its end."""
        return self.ended == "yes"

    def quantities(
        self, *, before: str, after: str, condition: str = "", penetration: float = PENETRATION, energy: float = ENERGY
    ) -> list[Quantity]:
        """The figures beside their limits.

        Args:
            before: knot with which the steps must set out.
            after: knot that must be there at the end.
            condition: distinguishes the runs of one case.
            penetration: largest allowed, over the diameter.
            energy: largest allowed error of the energy balance.
        """
        figures: list[tuple[str, float | str | None, float | str, Kind]] = [
            ("finished", self.ended, "yes", "equal"),
            ("cutbacks", float(self.cutbacks), max(FEW_CUTBACKS, CUTBACKS * self.steps), "at most"),
            ("smallest J", self.jacobian, SMALLEST_J, "at least"),
            ("penetration / d", self.penetration, penetration, "at most"),
            ("knot before", self.before, before, "equal"),
            ("knot after", self.after, after, "equal"),
            ("energy error", self.energy_error, energy, "at most"),
        ]
        return [
            Quantity(name, found, limit, kind=kind, condition=condition)
            for name, found, limit, kind in figures
            if found is not None
        ]


def make_outcome(
    ended: str,
    scene: Scene,
    summary: Mapping[str, Any],
    tables: Mapping[str, Table],
    log: Sequence[Mapping[str, Any]],
) -> Outcome:
    """The outcome of a run.

    Args:
        ended: "yes", or the error that ended it.
        scene: what was run.
        summary: figures of the whole run.
        tables: "force" and "tension".
        log: records of all steps.
    """
    return Outcome(
        ended,
        int(summary["steps"]),
        int(summary["cutbacks"]),
        float(summary["min_jacobian"]),
        float(summary["max_penetration_over_d"]),
        _knots(summary.get("knot_before_details")),
        _knots(summary.get("knot_after_details")),
        _energy_error(tables["force"]),
        scene,
        int(summary["newton_iterations"]),
        tables["force"],
        tables["tension"],
        log,
    )


def _knots(rods: Mapping[str, Mapping[str, Any]] | None) -> str:
    """Names of the rods' knots; "" before they are tied."""
    return ", ".join(knot["name"] for knot in (rods or {}).values())


def _energy_error(force: Table) -> float | None:
    """Largest error of the balance over the largest of work, stored and dissipated energy; None without a row."""
    if not force or not force["missing_Nmm"].size:
        return None
    scale = max(float(np.abs(force[name]).max()) for name in ("work_Nmm", "elastic_Nmm", "friction_Nmm", "drag_Nmm"))
    return float(np.abs(force["missing_Nmm"]).max()) / scale if scale > 0.0 else None
