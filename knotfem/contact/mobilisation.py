"""Friction law of contact: friction is mobilised over a distance.

At the slip e the traction is mu N psi(|e|/s) along e, with psi(y) = 2 y - y^2 up to y = 1. The stick distance s is the
constant, not a stiffness: a constant stiffness would be infinitely stiff at light load, and Newton's method cycles
then. A contact that sticks is taken to keep no energy.
"""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.law import Penalty, penalty
from knotfem.geometry.rotation import dot

MOBILISED = 0.999
"""A contact slides where its friction force is at least this fraction of what its normal force allows: what was brought
along stands at the stick distance, but for rounding."""


@kernel(inline="always")
def mobilisation(y: float) -> tuple[float, float, float]:
    """Fraction psi of the friction limit mobilised at slip y (over the stick distance), psi/y and d psi/dy."""
    if y < 1.0:
        return 2.0 * y - y * y, 2.0 - y, 2.0 - 2.0 * y
    return 1.0, 1.0 / y, 0.0


@kernel(inline="always")
def friction_limit(gap: float, law: Penalty, mu: float, measure: float) -> tuple[float, float]:
    """Largest friction mu N of a contact that stands for a measure, and its slope with the overlap; 0 without touch."""
    _, pressure, slope = penalty(gap, law)
    return mu * measure * pressure, mu * measure * slope


@kernel(inline="always")
def traction_at(e: np.ndarray, size: float, limit: float, stick: float, out: np.ndarray) -> float:
    """Traction at the slip e (3) of a given size into out (3); returns psi/y of `mobilisation`."""
    _, psi_y, _ = mobilisation(size / stick)
    for i in range(3):
        out[i] = limit * psi_y / stick * e[i]
    return psi_y


@kernel(inline="always")
def mobilisation_energy(y: float) -> float:
    """Integral of psi from 0 to y."""
    if y < 1.0:
        return y * y - y**3 / 3.0
    return y - 1.0 / 3.0


@kernel(inline="always", error_model="numpy")
def slip_stiffness(e: np.ndarray, limit: float, stick: float, M: np.ndarray) -> float:
    """Derivative of the traction by the slip e (3) into M (3, 3); returns psi/y of `mobilisation`.

    M = limit/stick (psi' ee + psi/y (I - ee)) in the direction e/|e|.
    """
    size = np.sqrt(dot(e, e))
    _, psi_y, dpsi = mobilisation(size / stick)
    inverse = 1.0 / size if size > 0.0 else 0.0
    for i in range(3):
        for j in range(3):
            ee = e[i] * e[j] * inverse * inverse
            M[i, j] = limit / stick * ((dpsi - psi_y) * ee + (psi_y if i == j else 0.0))
    return psi_y


def mobilised(mu: np.ndarray, traction: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Whether friction of each contact is all but at its limit.

    Args:
        mu: coefficient, shape [contacts].
        traction: friction force [N], shape [contacts, 3].
        force: normal force [N], shape [contacts].

    Returns:
        Shape [contacts].
    """
    return (force > 0.0) & (np.linalg.norm(traction, axis=1) >= MOBILISED * mu * force)
