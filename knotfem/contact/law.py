"""Normal and friction laws of contact.

Normal: quadratic onset, then linear. With the overlap o = ramp/2 - gap the pressure is stiffness o^2/(2 ramp) for
0 < o < ramp and stiffness (o - ramp/2) above, so that contacts close smoothly.

Friction, mobilised over a distance: at the slip e the traction is mu N psi(|e|/s), psi(y) = 2 y - y^2 up to y = 1. The
stick distance s is the constant, not a stiffness: a constant stiffness would be infinitely stiff at light load.

Friction, a spring cut at the limit (Cundall and Strack 1979): the traction is k e up to mu N, mu N e/|e| beyond. Its
stiffness is constant, so that no elastic energy comes from a change of the normal force.
"""

from __future__ import annotations

from dataclasses import dataclass

from knotfem.compiled import kernel

MINDLIN_STIFFNESS_RATIO = 2.0 / 3.0
"""Tangential over normal stiffness of a Hertz contact, 2 (1 - nu)/(2 - nu), for nu = 1/2 (Mindlin 1949)."""


@dataclass(frozen=True)
class Penalty:
    """The normal law.

    Attributes:
        stiffness: [MPa/mm] of surfaces, [N/mm^2] of centrelines.
        ramp: overlap over which the pressure rises smoothly [mm].
    """

    stiffness: float
    ramp: float


@kernel(inline="always")
def penalty(gap: float, stiffness: float, ramp: float) -> tuple[float, float, float]:
    """Energy density, pressure and slope of the pressure with the overlap at a gap."""
    o = 0.5 * ramp - gap
    if o <= 0.0:
        return 0.0, 0.0, 0.0
    if o < ramp:
        return stiffness * o**3 / (6.0 * ramp), stiffness * o * o / (2.0 * ramp), stiffness * o / ramp
    return stiffness * (0.5 * o * o - 0.5 * ramp * o + ramp * ramp / 6.0), stiffness * (o - 0.5 * ramp), stiffness


@kernel(inline="always")
def mobilisation(y: float) -> tuple[float, float, float]:
    """Fraction psi of the friction limit mobilised at slip y (over the stick distance), psi/y and d psi/dy."""
    if y < 1.0:
        return 2.0 * y - y * y, 2.0 - y, 2.0 - 2.0 * y
    return 1.0, 1.0 / y, 0.0


@kernel(inline="always")
def mobilisation_energy(y: float) -> float:
    """Integral of psi from 0 to y."""
    if y < 1.0:
        return y * y - y**3 / 3.0
    return y - 1.0 / 3.0


@kernel(inline="always")
def spring_energy(slip: float, stiffness: float, limit: float) -> float:
    """Integral of the traction of a spring that is cut at a limit."""
    if stiffness * slip <= limit:
        return 0.5 * stiffness * slip * slip
    return limit * slip - 0.5 * limit * limit / stiffness


@kernel(inline="always")
def sliding_work(stiffness: float, before: float, after: float, trial: float) -> float:
    """Work of sliding when the slip is cut from `trial` to `after`, having been `before` a step ago; never negative.

    The spring works against the motion with a traction that goes linearly from one end of the step to the other; what
    it does not store is lost. That covers a spring that gives way because the normal force has fallen.
    """
    return 0.5 * stiffness * (before + after) * (trial - after)
