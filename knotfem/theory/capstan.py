"""A rope that slips on a cylinder: Euler's law, and what the thickness of the rope changes.

Friction acts on the surface of the rope, at the radius R of the cylinder; tension acts on the centreline, at R + r.
With a = r / (R + r), the balances of forces and moments of a rope of constant curvature give T ~ exp(Lambda phi) with

    mu a Lambda^2 + Lambda = mu (1 - a),

which is Euler's law Lambda = mu for a = 0. Bending stiffness is left out: T >> B / (R + r)^2.
Source: Euler, Mem. Acad. Sci. Berlin 18, 265 (1769). For ropes with a thickness: Grandgeorge, Sano and Reis, J. Mech.
Phys. Solids 164, 104885 (2022); Singh, J. Elast. 151, 321 (2022).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.theory.arguments import finite, fraction, not_negative, positive, scalar_or_array


def capstan_exponent(friction: ArrayLike, thickness: ArrayLike = 0.0) -> Any:
    """Lambda, the growth of ln T per radian where the rope slips.

    Args:
        friction: mu, 0 or above.
        thickness: a, the radius of the rope over that of its centreline, from 0 on and below 1.

    Returns:
        1/rad, of the broadcast shape.

    Raises:
        InputError: an argument out of range; the same holds for the other functions of this module.
    """
    mu, a = not_negative("friction", friction), fraction("thickness", thickness)
    return scalar_or_array(2.0 * mu * (1.0 - a) / (1.0 + np.sqrt(1.0 + 4.0 * mu**2 * a * (1.0 - a))))


def tension_ratio(friction: ArrayLike, angle: ArrayLike, thickness: ArrayLike = 0.0) -> Any:
    """Ratio of the tensions on both sides of the contact at the onset of slip, exp(Lambda phi).

    Args:
        friction: mu, 0 or above.
        angle: phi, swept by the contact [rad], 0 or above.
        thickness: a, see `capstan_exponent`.

    Returns:
        Larger over smaller tension, of the broadcast shape.
    """
    phi = not_negative("angle", angle)
    return scalar_or_array(np.exp(capstan_exponent(friction, thickness) * phi))


def capstan_friction(ratio: ArrayLike, angle: ArrayLike, thickness: ArrayLike = 0.0) -> Any:
    """Friction at which a ratio of tensions is the largest that holds: the inverse of `tension_ratio`.

    Args:
        ratio: larger over smaller tension, 1 or above.
        angle: phi, swept by the contact [rad], above 0.
        thickness: a, see `capstan_exponent`.

    Returns:
        mu, of the broadcast shape; infinite where no friction suffices, since Lambda < sqrt((1 - a) / a).
    """
    phi, a = positive("angle", angle), fraction("thickness", thickness)
    tensions = positive("ratio", ratio)
    if np.any(tensions < 1.0):
        raise InputError("out of range", key="ratio", found=float(tensions.min()), expected="numbers from 1 on")
    exponent = np.log(tensions) / phi
    left = 1.0 - a - a * exponent**2
    with np.errstate(divide="ignore"):
        return scalar_or_array(exponent / np.maximum(left, 0.0))


def tension_profile(
    arclength: ArrayLike,
    load: ArrayLike,
    friction: ArrayLike,
    angle: ArrayLike,
    radius: ArrayLike,
    thickness: ArrayLike = 0.0,
) -> Any:
    """Tension along a rope at the onset of slip.

    It is the load up to the contact, falls exponentially along the contact and is constant behind it.

    Args:
        arclength: along the centreline from the beginning of the contact on the loaded side [mm]; negative ahead of it.
        load: larger tension [N], 0 or above.
        friction: mu, 0 or above.
        angle: phi, swept by the contact [rad], 0 or above.
        radius: of the centreline on the cylinder, R + r [mm].
        thickness: a, see `capstan_exponent`.

    Returns:
        N, of the broadcast shape.
    """
    s, rho = finite("arclength", arclength), positive("radius", radius)
    swept = np.clip(s / rho, 0.0, not_negative("angle", angle))
    return scalar_or_array(not_negative("load", load) * np.exp(-capstan_exponent(friction, thickness) * swept))
