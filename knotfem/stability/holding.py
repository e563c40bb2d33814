"""What a knot bears before it slips: the largest force until a free end has been drawn in by so much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from knotfem.scene.steps import Load, Pull
from knotfem.stability.verdict import SLIP_OVER_DIAMETER

LoadingStep = Pull | Load
"""Steps that pull or load a knot on and on."""


def slip_of(step: LoadingStep, diameter: float) -> float:
    """Length by which a free end may be drawn in before the knot has slipped [mm].

    Args:
        step: that loads it.
        diameter: of the thinnest rod [mm].
    """
    return SLIP_OVER_DIAMETER * diameter if step.slip is None else step.slip


@dataclass
class Holding:
    """Follows force and slip through a step that pulls or loads a knot whose free ends may run.

    Only equilibria count as borne. Where the slip passes the length between two of them, forces are interpolated;
    where it does so in a jump, the last equilibrium before it counts.

    Attributes:
        slip: length that a free end may be drawn in by [mm].
        force: largest force in equilibrium before that [N]; None before the first.
        displacement: of the reported end since the step began, at this force [mm].
        slipped: whether a free end has been drawn in by more.
        slip_force: force at which it was [N]; None while it was not.
        slip_displacement: of the reported end then [mm].
        drawn_in: by how much in the last state [mm].
        last: displacement, force and length drawn in of the last equilibrium.
    """

    slip: float
    force: float | None = None
    displacement: float | None = None
    slipped: bool = False
    slip_force: float | None = None
    slip_displacement: float | None = None
    drawn_in: float = 0.0
    last: tuple[float, float, float] | None = None

    def update(self, displacement: float, force: float, drawn_in: float, *, settled: bool) -> None:
        """Take an accepted state.

        Args:
            displacement: of the reported end since the step began [mm].
            force: on it [N].
            drawn_in: length of the free end that has been drawn in furthest since the step began [mm].
            settled: whether the state is one of equilibrium.
        """
        self.drawn_in = drawn_in
        if self.slipped:
            return
        if drawn_in > self.slip:
            self._pass(displacement, force, drawn_in, settled)
        elif settled:
            self._bear(displacement, force)
            self.last = displacement, force, drawn_in

    def figures(self) -> dict[str, Any]:
        """For the summary."""
        return {
            "slip_mm": self.slip,
            "slipped": self.slipped,
            "holding_force_N": self.force,
            "at_step_displacement_mm": self.displacement,
            "slipping_force_N": self.slip_force,
            "slipped_at_step_displacement_mm": self.slip_displacement,
            "drawn_in_mm": self.drawn_in,
        }

    def __str__(self) -> str:
        if self.force is None:
            return f"no equilibrium before a free end was drawn in by {self.slip:g} mm"
        borne = f"{self.force:.4g} N at {self.displacement:.4g} mm"
        if self.slip_force is None:
            ran = f"a free end was drawn in by {self.drawn_in:.3g} mm" if self.drawn_in > 0.0 else "no end was drawn in"
            return f"holding force at least {borne}: {ran}"
        return (
            f"holding force {borne}, the largest before a free end was drawn in by {self.slip:g} mm; "
            f"{self.slip_force:.4g} N at {self.slip_displacement:.4g} mm, when it was"
        )

    def _bear(self, displacement: float, force: float) -> None:
        if self.force is None or force > self.force:
            self.force, self.displacement = force, displacement

    def _pass(self, displacement: float, force: float, drawn_in: float, settled: bool) -> None:
        self.slipped = True
        if self.last is None:
            return
        before = self.last
        part = (self.slip - before[2]) / (drawn_in - before[2]) if settled else 0.0
        self.slip_displacement = before[0] + part * (displacement - before[0])
        self.slip_force = before[1] + part * (force - before[1])
        self._bear(self.slip_displacement, self.slip_force)
