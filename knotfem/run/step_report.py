"""What progress shows of the events of a simulation."""

from __future__ import annotations

from typing import Literal

from knotfem.models.base import Increment
from knotfem.run.events import TimeStepDone
from knotfem.run.step_figures import StepReport
from knotfem.scene.steps import Pull, Relax, Step


def report_of(event: Increment | TimeStepDone) -> StepReport:
    """What progress shows of an event."""
    if isinstance(event, Increment):
        stretch = float(event.stretch.min()), float(event.stretch.max())
        done = event.mapping_time
        return StepReport(
            "mapping", done, done, iterations=event.iterations, kind="mapping", stretch=stretch, due=done >= 1.0
        )
    figures, accepted = event.figures, event.accepted
    kinds: dict[type[Step], Literal["relax", "pull"]] = {Relax: "relax", Pull: "pull"}
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
        kinds.get(type(event.step), "load"),
        due=event.output,
    )
