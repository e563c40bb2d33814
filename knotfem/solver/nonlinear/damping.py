"""Levenberg-Marquardt damping of Newton's method."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LevenbergMarquardt:
    """A diagonal that is added to the tangent, weighted by the volume of each node.

    Contacts open and close on a rod that gives way sideways at 0.004 N/mm while a contact sample pushes back at
    27 N/mm: the tangent is often near singular. Damping is the main globaliser; without it a loose pull takes 59
    iterations instead of 27.

    Attributes:
        start: first value [N/mm], all nodes together; below it there is none.
        cap: largest value [N/mm]; without a cap it ran away to 1e4 and nothing moved.
        raise_by: factor where a step is too long, is shortened or meets a singular matrix.
        lower_by: factor after a whole step.
        release_by: factor after a step that is small or lets prescribed nodes catch up.
    """

    start: float = 0.01
    cap: float = 100.0
    raise_by: float = 4.0
    lower_by: float = 0.5
    release_by: float = 0.25

    def raised(self, value: float) -> float:
        """The next larger value [N/mm]."""
        return min(max(self.raise_by * value, self.start), self.cap)

    def lowered(self, value: float) -> float:
        """After a whole step [N/mm]."""
        return 0.0 if value < self.start else self.lower_by * value

    def released(self, value: float) -> float:
        """After a small step [N/mm]."""
        return 0.0 if value < self.start else self.release_by * value

    def exhausted(self, value: float) -> bool:
        """Whether it cannot be raised."""
        return value >= self.cap
