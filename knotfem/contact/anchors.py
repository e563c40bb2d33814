"""Friction of tubes from anchors, mobilised over a stick distance: what is common to rods and obstacles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel
from knotfem.contact.law import mobilisation
from knotfem.geometry.rotation import dot

MOBILISED = 0.999
"""A contact slides where its friction force is at least this fraction of what its normal force allows: an anchor that
was brought along stands at the stick distance, but for rounding."""


class AnchorView(NamedTuple):
    """Friction of each contact of a tube.

    Attributes:
        mu: coefficient, shape [contacts].
        anchor: parameters on the primary surface, shape [contacts, 2], or a point of the obstacle, shape [contacts, 3].
        slip: |e| of contacts that carry force [mm], shape [contacts].
        traction: on the secondary surface [N], shape [contacts, 3].
        stick: distance over which friction is mobilised [mm].
    """

    mu: np.ndarray
    anchor: np.ndarray
    slip: np.ndarray
    traction: np.ndarray
    stick: float


@kernel(inline="always", error_model="numpy")
def anchor_stiffness(e: np.ndarray, limit: float, stick: float, M: np.ndarray) -> float:
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


def mobilised(view: AnchorView, force: np.ndarray) -> np.ndarray:
    """Whether friction of each contact is all but at its limit, for normal forces [N], shape [contacts]."""
    size = np.linalg.norm(view.traction, axis=1)
    return (force > 0.0) & (size >= MOBILISED * view.mu * force)
