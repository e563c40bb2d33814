"""One accepted step as progress shows it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class StepReport:
    """One accepted step, as progress shows it.

    Attributes:
        phase: such as "mapping", "relax", "pull".
        fraction: of the phase that is done, 0 to 1; NaN where nobody knows.
        time: since the start of the phase [s].
        displacement: of the driven ends [mm].
        force: at the driven or loaded end [N].
        step: size of the step [mm] or, where nothing is driven, [s].
        contacts: surface points in contact.
        penetration: deepest one [mm].
        iterations: of Newton's method.
        kind: "mapping", "relax" for steps without load, "pull" where ends are driven, or "load".
        stretch: smallest and largest of the centreline, while mapping; else None.
        due: whether an output is due, or the phase ends.
    """

    phase: str
    fraction: float = math.nan
    time: float = 0.0
    displacement: float = 0.0
    force: float = 0.0
    step: float = 0.0
    contacts: int = 0
    penetration: float = 0.0
    iterations: int = 0
    kind: Literal["mapping", "relax", "pull", "load"] = "pull"
    stretch: tuple[float, float] | None = None
    due: bool = False


def figures(report: StepReport, width: int = 1000) -> str:
    """The step's figures with their units, as many as there is room for, the most important ones at least.

    Args:
        report: of the step.
        width: characters that there are.
    """
    parts = _parts(report)
    while len(parts) > 1 and len("  ".join(text for text, _ in parts)) > width:
        parts.remove(max(parts, key=lambda part: part[1]))
    return "  ".join(text for text, _ in parts)


def _parts(report: StepReport) -> list[tuple[str, int]]:
    """Figures of a step in their order, each with the place at which it is left out where room is short."""
    iterations = _count(report.iterations, "iteration"), 3
    if report.kind == "mapping":
        found = [] if report.stretch is None else [("stretch {:.3f} to {:.3f}".format(*report.stretch), 0)]
        return found + [iterations] * (report.iterations > 0) or [("", 0)]
    unit = "mm" if report.kind == "pull" else "s"
    touching = (_count(report.contacts, "contact"), 2), (f"{report.penetration:.3f} mm deep", 4)
    if report.kind == "relax":
        return [*touching, iterations]
    return [
        (f"{report.displacement:.2f} mm", 0), (f"{report.force:.4f} N", 1), *touching, iterations,
        (f"step {report.step:.2g} {unit}", 5), (f"simulated {report.time:.3g} s", 6),
    ]  # fmt: skip


def _count(number: int, name: str) -> str:
    return f"{number} {name}{'s' * (number != 1)}"
