"""Open overhand knots whose loop is much larger than the rod, and longer braids.

A loop of radius R is closed by a braid of n turns of two rods of radius r; n = 1 is the open trefoil (3_1), n = 2 the
open cinquefoil (5_1). All laws are the first terms of expansions in eps = sqrt(r / R).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.theory.arguments import not_negative, positive, scalar_or_array

SIGMA = {1: 0.492, 2: 1.475}
"""Sum of the contact forces in a braid of n turns over eps^3 B / r^2 (Audoly, Clauvelin and Neukirch 2007)."""


def loose_knot_contact_force(eps: ArrayLike, turns: int = 1) -> Any:
    """Sum of the contact forces of an open knot without friction, N r^2 / B = sigma eps^3.

    Source: Audoly, Clauvelin and Neukirch, Phys. Rev. Lett. 99, 164301 (2007).

    Args:
        eps: sqrt(r / R), above 0.
        turns: n, 1 or 2.

    Returns:
        In units of B / r^2, of the shape of eps.

    Raises:
        InputError: an argument out of range; the same holds for the other functions of this module.
    """
    if turns not in SIGMA:
        raise InputError("no sigma is known", key="turns", found=turns, expected="1 or 2")
    return scalar_or_array(SIGMA[turns] * positive("eps", eps) ** 3)


def loose_knot_force(eps: ArrayLike, friction: ArrayLike = 0.0, turns: int = 1) -> Any:
    """Tension at which an open knot slips tighter, F r^2 / B = eps^4 / 2 + mu sigma eps^3.

    Source: Audoly, Clauvelin and Neukirch, Phys. Rev. Lett. 99, 164301 (2007).

    Args:
        eps: sqrt(r / R), above 0.
        friction: mu, 0 or above.
        turns: n, 1 or 2.

    Returns:
        In units of B / r^2, of the broadcast shape.
    """
    rubbing = not_negative("friction", friction) * loose_knot_contact_force(eps, turns)
    return scalar_or_array(0.5 * positive("eps", eps) ** 4 + rubbing)


def braid_wave_number(eps: ArrayLike) -> Any:
    """Wave number k of the two rods of a long braid, k = (sqrt(12) r R)^(-1/2).

    Source: Jawed, Dieleman, Audoly and Reis, Phys. Rev. Lett. 115, 118302 (2015).

    Args:
        eps: sqrt(r / R), above 0.

    Returns:
        r k, of the shape of eps.
    """
    return scalar_or_array(12.0**-0.25 * positive("eps", eps))


def braid_force(wave_number: ArrayLike, friction: ArrayLike, turns: ArrayLike) -> Any:
    """Tension of a long braid held by friction alone, F / (B k^2) = 2 pi n mu r k.

    Source: Jawed, Dieleman, Audoly and Reis, Phys. Rev. Lett. 115, 118302 (2015).

    Args:
        wave_number: r k, above 0.
        friction: mu, 0 or above.
        turns: n, above 0.

    Returns:
        In units of B / r^2, of the broadcast shape.
    """
    mu, n = not_negative("friction", friction), positive("turns", turns)
    return scalar_or_array(2.0 * np.pi * n * mu * positive("wave_number", wave_number) ** 3)
