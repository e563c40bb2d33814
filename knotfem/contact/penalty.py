"""The normal penalty law: quadratic onset, then linear.

With overlap o = ramp/2 - gap the pressure is stiffness o^2 / (2 ramp) for 0 < o < ramp and
stiffness (o - ramp/2) above.
"""

from __future__ import annotations

from dataclasses import dataclass

from knotfem.compiled import kernel


@dataclass(frozen=True)
class Penalty:
    """Attributes: stiffness [MPa/mm], ramp [mm], stick [mm]: slip at which friction is fully mobilised."""

    stiffness: float
    ramp: float
    stick: float


@kernel(inline="always")
def penalty(gap, stiffness, ramp):
    """Energy density, pressure and slope of the pressure with the overlap at a gap."""
    o = 0.5 * ramp - gap
    if o <= 0.0:
        return 0.0, 0.0, 0.0
    if o < ramp:
        return stiffness * o**3 / (6.0 * ramp), stiffness * o * o / (2.0 * ramp), stiffness * o / ramp
    return stiffness * (0.5 * o * o - 0.5 * ramp * o + ramp * ramp / 6.0), stiffness * (o - 0.5 * ramp), stiffness


@kernel(inline="always")
def mobilisation(y):
    """Share psi of the friction limit mobilised at slip y (over the stick distance), psi / y and d psi / d y."""
    if y < 1.0:
        return 2.0 * y - y * y, 2.0 - y, 2.0 - 2.0 * y
    return 1.0, 1.0 / y, 0.0


@kernel(inline="always")
def mobilisation_energy(y):
    """Integral of psi from 0 to y."""
    if y < 1.0:
        return y * y - y**3 / 3.0
    return y - 1.0 / 3.0
