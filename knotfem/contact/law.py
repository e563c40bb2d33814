"""Normal law of contact: quadratic onset, then linear.

With the overlap o = onset - gap the pressure is stiffness o^2/(2 ramp) for 0 < o < ramp and stiffness (o - ramp/2) for
larger ones, so that contacts close smoothly. An onset of half the ramp makes the pressure stiffness times penetration
where surfaces are pressed hard.
"""

from __future__ import annotations

from typing import NamedTuple

from knotfem.compiled import kernel


class Penalty(NamedTuple):
    """The normal law.

    Attributes:
        stiffness: [MPa/mm] of surfaces, [N/mm^2] of centrelines.
        ramp: overlap over which the pressure rises smoothly [mm].
        onset_over_ramp: gap at which contact begins, over the ramp.
    """

    stiffness: float
    ramp: float
    onset_over_ramp: float = 0.5

    @property
    def onset(self) -> float:
        """Gap at which contact begins [mm]."""
        return self.onset_over_ramp * self.ramp


@kernel(inline="always")
def penalty(gap: float, law: Penalty) -> tuple[float, float, float]:
    """Energy density, pressure and slope of the pressure with the overlap at a gap."""
    stiffness, ramp = law.stiffness, law.ramp
    o = law.onset_over_ramp * ramp - gap
    if o <= 0.0:
        return 0.0, 0.0, 0.0
    if o < ramp:
        return stiffness * o**3 / (6.0 * ramp), stiffness * o * o / (2.0 * ramp), stiffness * o / ramp
    return stiffness * (0.5 * o * o - 0.5 * ramp * o + ramp * ramp / 6.0), stiffness * (o - 0.5 * ramp), stiffness
