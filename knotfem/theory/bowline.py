"""The force at which the central rods of a bowline slip through the rod that is wrapped around them.

The wrapping rod carries a tension T at a curvature kappa and presses on the central rods. They slip under a force

    F_s = phi mu T                                where T >> B kappa^2   (Eqs. 2 and 3a of the paper, phi = 2 pi),
    F_s = beta mu T^alpha (B kappa^2)^(1 - alpha) where T << B kappa^2   (Eq. 3b).

The first is that of a flexible string that sweeps an angle phi. The second is a power law measured on granny knots
(Johanns et al. 2023, alpha = 1.56 +- 0.23, cited by the paper), completed by dimensional analysis; it is not derived.
With alpha > 1, each law gives the smaller force where it applies. The force is taken as the smaller one throughout.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.theory.arguments import finite, not_negative, positive, scalar_or_array
from knotfem.types import Array

ONE_TURN = 2.0 * np.pi
"""Angle phi swept by the wrapping rod [rad]."""
MEAN_TENSION = 0.75
"""Of the wrapping rod, over the load T0: the mean of T0 at one end and T0/2 at the other."""
CURVATURE = 0.5
"""Of the wrapping rod, times the rod radius r.

A centreline that bends around one rod of radius r has the radius 2r. The paper replaces both central rods by one rod of
radius 2r, around which it would be 3r, and takes 1/2r all the same. A fitted beta contains that choice.
"""


@dataclass(frozen=True)
class Parameters:
    """Of the law for stiff rods.

    Attributes:
        alpha: exponent of tension, above 1.
        beta: factor, above 0.
        alpha_error: standard error of alpha.
        beta_error: standard error of beta.
        correlation: of both, between -1 and 1.

    Raises:
        InputError: a value out of range.
    """

    alpha: float
    beta: float
    alpha_error: float = 0.0
    beta_error: float = 0.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        if positive("alpha", self.alpha) <= 1.0:
            raise InputError("out of range", key="alpha", found=self.alpha, expected="a number above 1")
        positive("beta", self.beta)
        not_negative("alpha_error", self.alpha_error)
        not_negative("beta_error", self.beta_error)
        if abs(finite("correlation", self.correlation)) > 1.0:
            raise InputError("out of range", key="correlation", found=self.correlation, expected="from -1 to 1")

    @property
    def covariance(self) -> Array:
        """Of alpha and beta, shape [2, 2]."""
        errors = np.array([self.alpha_error, self.beta_error])
        return np.outer(errors, errors) * np.array([[1.0, self.correlation], [self.correlation, 1.0]])


PAPER = Parameters(alpha=1.69, beta=10.6, alpha_error=0.04, beta_error=1.0)
"""Fitted by the paper to the boundary of its discrete element simulations. It states no correlation."""


def flexible_holding_force(tension: ArrayLike, friction: ArrayLike, angle: ArrayLike = ONE_TURN) -> Any:
    """F_s of a rod without bending stiffness, phi mu T (Eq. 3a).

    Args:
        tension: T of the wrapping rod [N], above 0.
        friction: mu between the rods, 0 or above.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        N, of the broadcast shape.

    Raises:
        InputError: an argument out of range; the same holds for the other functions of this module.
    """
    swept = positive("angle", angle)
    return scalar_or_array(swept * not_negative("friction", friction) * positive("tension", tension))


def stiff_holding_force(
    tension: ArrayLike, friction: ArrayLike, bending_force: ArrayLike, parameters: Parameters = PAPER
) -> Any:
    """F_s of a rod under little tension, beta mu T^alpha (B kappa^2)^(1 - alpha) (Eq. 3b).

    Args:
        tension: T of the wrapping rod [N], above 0.
        friction: mu between the rods, 0 or above.
        bending_force: B kappa^2 [N], above 0.
        parameters: alpha and beta.

    Returns:
        N, of the broadcast shape.
    """
    T, scale = positive("tension", tension), positive("bending_force", bending_force)
    mu = not_negative("friction", friction)
    return scalar_or_array(parameters.beta * mu * scale * (T / scale) ** parameters.alpha)


def holding_force(
    tension: ArrayLike,
    friction: ArrayLike,
    bending_force: ArrayLike,
    parameters: Parameters = PAPER,
    angle: ArrayLike = ONE_TURN,
) -> Any:
    """F_s at any tension: the smaller one of `flexible_holding_force` and `stiff_holding_force`.

    Args:
        tension: T of the wrapping rod [N], above 0.
        friction: mu between the rods, 0 or above.
        bending_force: B kappa^2 [N], above 0.
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        N, of the broadcast shape.
    """
    stiff = stiff_holding_force(tension, friction, bending_force, parameters)
    return scalar_or_array(np.minimum(flexible_holding_force(tension, friction, angle), stiff))


def crossing(parameters: Parameters = PAPER, angle: ArrayLike = ONE_TURN) -> Any:
    """x = B / (T0 r^2) at which both laws give the same force; the law for stiff rods applies above it.

    T = 3 T0 / 4 and kappa = 1 / 2r give T / (B kappa^2) = 3 / x and a crossing at x = 3 (beta / phi)^(1 / (alpha - 1)).
    That is 6.40 with the paper's parameters. The paper expects beta near 2 pi, from a crossing at T = B kappa^2, x = 3.

    Args:
        parameters: alpha and beta.
        angle: phi, swept by the wrapping rod [rad], above 0.

    Returns:
        Of the shape of `angle`.
    """
    tension = (positive("angle", angle) / parameters.beta) ** (1.0 / (parameters.alpha - 1.0))
    return scalar_or_array(MEAN_TENSION / (CURVATURE**2 * tension))
