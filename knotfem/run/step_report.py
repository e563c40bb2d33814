"""What progress shows of the events of a simulation."""

from __future__ import annotations

from knotfem.models.base import Increment
from knotfem.run.progress import StepReport
from knotfem.run.simulation import TimeStepDone
from knotfem.scene.steps import Pull


def report_of(event: Increment | TimeStepDone) -> StepReport:
    """What progress shows of an event."""
    if isinstance(event, Increment):
        return StepReport("mapping", event.mapping_time, event.mapping_time, iterations=event.iterations)
    figures, accepted = event.figures, event.accepted
    size = accepted.advance * (event.step.nominal_speed if isinstance(event.step, Pull) else 1.0)
    return StepReport(
        event.step.name,
        event.fraction,
        event.elapsed,
        event.displacement,
        figures.force,
        size,
        figures.contacts,
        figures.penetration,
        accepted.solution.iterations,
    )
