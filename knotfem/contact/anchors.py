"""Friction of tubes from anchors, mobilised over a stick distance: what is common to rods and obstacles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from knotfem.types import Arrays


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


def anchor_view(mu: np.ndarray, rows: Arrays, stick: float) -> AnchorView:
    """From coefficients, what contacts remember, and the stick distance; nothing slips yet."""
    return AnchorView(mu, rows["anchor"], np.zeros(mu.size), np.zeros((mu.size, 3)), stick)
