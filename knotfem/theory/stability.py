"""The friction above which a bowline holds, against x = B / (T0 r^2) with the load T0 and the rod radius r.

The tension falls twice in the locking unit: from T0 to T0/2 along the wrapping rod, and from T0/2 to 0 along one of the
two central rods. The knot fails when friction cannot carry one of the two drops. It holds where the coefficient of
friction is at least the larger one of two thresholds:

- The wrapping rod slips below mu_s = ln 2 / phi (Eq. 1).
- The central rods slip where F_s < T0 / 2, with T = 3 T0 / 4 and kappa = 1 / 2r in the wrapping rod: below 1 / 3 pi for
  T0 >> B / r^2 (Eq. 4a, phi = 2 pi) and below 2 x^(alpha - 1) / (3^alpha beta) for T0 << B / r^2 (Eq. 4b). As F_s is
  the smaller force of the two laws, the larger of these two thresholds counts.

Slips of the paper's text:

- Below Eq. 1, "sliding is prevented if mu_s >~ 0.11" should read mu_rr; mu_s is the threshold.
- "1 / (1 - alpha) = 1.7", the exponent of Eq. 4b, should read 1 / (alpha - 1) = 1.45 (alpha = 1.69).
- The simulated threshold of very flexible rods, 0.09, is said to agree with Eq. 1, which gives 0.110 for one turn (Eq.
  4a: 0.106). Both equations allow 0.09 only if the rod sweeps at least 7.7 rad, 1.23 turns.
- That both thresholds of flexible rods are close is called a coincidence. They differ by the mean tension only: a
  tension that falls exponentially from T0 to T0/2 has the mean T0 / (2 ln 2) = 0.721 T0. With this mean in place of
  3 T0 / 4, Eq. 4a is the same as Eq. 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.theory.arguments import not_negative, positive, scalar_or_array
from knotfem.theory.bowline import (
    CURVATURE,
    MEAN_TENSION,
    ONE_TURN,
    PAPER,
    Parameters,
    holding_force,
    stiff_holding_force,
)
from knotfem.theory.capstan import capstan_friction

TENSION_DROP = 0.5
"""Of the central rods as of the wrapping rod, over the load T0."""
WRAPPING_ROD, CENTRAL_RODS = "wrapping rod slips", "central rods slip"
"""The modes of failure."""


def wrapping_rod_friction(angle: ArrayLike = ONE_TURN) -> Any:
    """mu_s = ln 2 / phi, below which the wrapping rod slips (Eq. 1); 0.110 for one turn.

    Args:
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        Of the shape of `angle`.

    Raises:
        InputError: an argument out of range; the same holds for the other functions of this module.
    """
    return capstan_friction(1.0 / (1.0 - TENSION_DROP), angle)


def stiff_friction(x: ArrayLike, parameters: Parameters = PAPER) -> Any:
    """2 x^(alpha - 1) / (3^alpha beta), below which the central rods of stiff rods slip (Eq. 4b).

    This is the line that the paper fits in its stability diagram. The law for stiff rods applies above `crossing`;
    below, it gives less than the thresholds of flexible rods, and `critical_friction` does not use it.

    Args:
        x: B / (T0 r^2), above 0.
        parameters: alpha and beta.

    Returns:
        mu, of the shape of x.
    """
    bending_force = CURVATURE**2 * positive("x", x)
    return scalar_or_array(TENSION_DROP / stiff_holding_force(MEAN_TENSION, 1.0, bending_force, parameters))


def stiff_friction_error(x: ArrayLike, parameters: Parameters = PAPER) -> Any:
    """Standard error of `stiff_friction` from those of the parameters, to first order.

    Args:
        x: B / (T0 r^2), above 0.
        parameters: alpha and beta with their errors. Where their correlation is not known, as in the paper, it is
            taken as 0; the error between the points of a fit is then too large.

    Returns:
        Of the shape of x.
    """
    mu = np.asarray(stiff_friction(x, parameters))
    by_alpha = np.log(positive("x", x) * CURVATURE**2 / MEAN_TENSION)
    slope = np.stack([by_alpha, np.full_like(by_alpha, -1.0 / parameters.beta)], axis=-1)
    variance = np.einsum("...i,ij,...j->...", slope, parameters.covariance, slope)
    return scalar_or_array(mu * np.sqrt(np.maximum(variance, 0.0)))


def critical_stiffness(friction: ArrayLike, parameters: Parameters = PAPER) -> Any:
    """x up to which the central rods of stiff rods hold, (3^alpha beta mu / 2)^(1 / (alpha - 1)) (Eq. 4b).

    Args:
        friction: mu between the rods, 0 or above.
        parameters: alpha and beta.

    Returns:
        B / (T0 r^2), of the shape of `friction`.
    """
    mu = not_negative("friction", friction)
    return scalar_or_array((mu / stiff_friction(1.0, parameters)) ** (1.0 / (parameters.alpha - 1.0)))


def central_rods_friction(x: ArrayLike, parameters: Parameters = PAPER, angle: ArrayLike = ONE_TURN) -> Any:
    """Friction below which the central rods slip: 2 / (3 phi) up to `crossing` (Eq. 4a), `stiff_friction` above.

    Args:
        x: B / (T0 r^2), above 0.
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        mu, of the broadcast shape.
    """
    bending_force = CURVATURE**2 * positive("x", x)
    return scalar_or_array(TENSION_DROP / holding_force(MEAN_TENSION, 1.0, bending_force, parameters, angle))


def critical_friction(x: ArrayLike, parameters: Parameters = PAPER, angle: ArrayLike = ONE_TURN) -> Any:
    """Friction from which on the bowline holds: the larger one of the thresholds of both modes.

    Args:
        x: B / (T0 r^2), above 0.
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        mu, of the broadcast shape.
    """
    return scalar_or_array(np.maximum(wrapping_rod_friction(angle), central_rods_friction(x, parameters, angle)))


def failure_mode(x: ArrayLike, parameters: Parameters = PAPER, angle: ArrayLike = ONE_TURN) -> Any:
    """Mode in which the knot fails first when friction falls: `WRAPPING_ROD` or `CENTRAL_RODS`.

    Args:
        x: B / (T0 r^2), above 0.
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        Text, or an array of the broadcast shape.
    """
    central = central_rods_friction(x, parameters, angle) > np.asarray(wrapping_rod_friction(angle))
    return scalar_or_array(np.where(central, CENTRAL_RODS, WRAPPING_ROD))


def holds(x: ArrayLike, friction: ArrayLike, parameters: Parameters = PAPER, angle: ArrayLike = ONE_TURN) -> Any:
    """Whether the bowline holds.

    Args:
        x: B / (T0 r^2), above 0.
        friction: mu between the rods, 0 or above.
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        bool, or an array of the broadcast shape.
    """
    return scalar_or_array(not_negative("friction", friction) >= critical_friction(x, parameters, angle))
