"""The parameters of the law for stiff rods, Eq. 3b of the paper, from measurements.

In logarithms the law is a straight line, ln (F_s / (mu B kappa^2)) = ln beta + alpha ln (T / (B kappa^2)), and so is
the boundary that follows from it, Eq. 4b. It is fitted by linear least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.theory.arguments import positive
from knotfem.theory.bowline import CURVATURE, MEAN_TENSION, Parameters
from knotfem.theory.stability import TENSION_DROP
from knotfem.types import Array

FEWEST_POINTS = 3
"""Two parameters, and one point more that tells whether they describe the data."""
FLAT = 1.0 / np.sqrt(12.0)
"""Standard deviation of a value that lies anywhere in an interval, over the width of the interval."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit(Parameters):
    """Parameters with standard errors, correlation and covariance, from a fit.

    Attributes:
        residuals: ln (measured / fitted) of each point, shape [n].
        spread: root of the sum of squared residuals in units of their errors, over n - 2. Near 1 the law describes the
            data; well above 1 it does not. NaN where no errors were given.
    """

    residuals: Array
    spread: float


def fit_holding_force(
    force: ArrayLike,
    tension: ArrayLike,
    friction: ArrayLike,
    bending_force: ArrayLike,
    error: ArrayLike | None = None,
) -> Fit:
    """Fit Eq. 3b to forces at which central rods slipped.

    Points must have tensions at which the law applies, well below B kappa^2.

    Args:
        force: F_s [N], above 0, shape [n] with n >= 3.
        tension: T of the wrapping rod [N], above 0; like the next two, shape [n] or one number.
        friction: mu between the rods, above 0.
        bending_force: B kappa^2 [N], above 0.
        error: standard errors of the forces [N], above 0. None takes all relative errors as equal and finds them from
            the residuals. Errors that are given set the standard errors of the parameters; where the residuals spread
            more than they allow, the standard errors are raised by `Fit.spread`.

    Raises:
        InputError: too few points, values that are not finite or not above 0, shapes that do not agree, tensions that
            are all the same over B kappa^2, or an alpha of 1 or below.
    """
    given = {"force": force, "tension": tension, "friction": friction, "bending_force": bending_force}
    F, T, mu, scale, *errors = _points(given | ({} if error is None else {"error": error}))
    return _fit_line(np.log(T / scale), np.log(F / (mu * scale)), errors[0] / F if errors else None)


def fit_boundary(x: ArrayLike, friction: ArrayLike, width: ArrayLike | None = None) -> Fit:
    """Fit Eq. 4b to the friction at which bowlines begin to hold.

    Points must be such that the central rods slip there and rods are stiff: above `crossing`.

    Args:
        x: B / (T0 r^2), above 0, shape [n] with n >= 3.
        friction: threshold of mu, the middle of a bracket, above 0, shape [n].
        width: of the brackets, from the largest friction at which the knot failed to the smallest at which it held,
            above 0, shape [n] or one number. A threshold is as likely anywhere in its bracket: its standard error is
            width / sqrt(12). None takes all relative errors as equal; see `fit_holding_force`.

    Raises:
        InputError: see `fit_holding_force`.
    """
    stiffness, mu, *widths = _points({"x": x, "friction": friction} | ({} if width is None else {"width": width}))
    scale = CURVATURE**2 * stiffness
    error = FLAT * widths[0] / mu if widths else None
    fit = _fit_line(np.log(MEAN_TENSION / scale), np.log(TENSION_DROP / (mu * scale)), error)
    return replace(fit, residuals=-fit.residuals)


def _points(given: dict[str, ArrayLike]) -> list[Array]:
    """Arrays of one length n, each from n values or from one."""
    arrays = {name: positive(name, values) for name, values in given.items()}
    shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
    try:
        points = np.broadcast_arrays(*arrays.values())
    except ValueError:
        raise InputError("the shapes do not agree", found=shapes, expected="[n] or one number each") from None
    if points[0].ndim != 1 or points[0].size < FEWEST_POINTS:
        raise InputError("too few points for a fit", found=shapes, expected=f"[n] with n >= {FEWEST_POINTS}")
    return list(points)


def _fit_line(log_tension: Array, log_force: Array, error: Array | None) -> Fit:
    """Alpha and beta of log_force = ln beta + alpha log_tension.

    Args:
        log_tension: shape [n].
        log_force: shape [n].
        error: standard errors of log_force, shape [n]; None where they are equal and not known.
    """
    if np.ptp(log_tension) < 1e-9:
        raise InputError("all points have the same tension over B kappa^2", expected="two different values or more")
    weight = np.ones_like(log_force) if error is None else error**-2.0
    mean_tension, mean_force = np.average(log_tension, weights=weight), np.average(log_force, weights=weight)
    away = log_tension - mean_tension
    squares = np.sum(weight * away**2)
    alpha = float(np.sum(weight * away * log_force) / squares)
    beta = float(np.exp(mean_force - alpha * mean_tension))
    residuals = log_force - mean_force - alpha * away
    spread = float(np.sqrt(np.sum(weight * residuals**2) / (residuals.size - 2)))
    scale = spread if error is None else max(spread, 1.0)
    log_beta_error = scale * float(np.sqrt(1.0 / weight.sum() + mean_tension**2 / squares))
    alpha_error = scale / float(np.sqrt(squares))
    return Fit(
        alpha=alpha,
        beta=beta,
        alpha_error=alpha_error,
        beta_error=beta * log_beta_error,
        correlation=-float(mean_tension) * alpha_error / log_beta_error if scale > 0.0 else 0.0,
        residuals=residuals,
        spread=float("nan") if error is None else spread,
    )
