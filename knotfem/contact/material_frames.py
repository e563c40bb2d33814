"""Frames of the segments of a rod, from which material points are carried."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np


class FrameView(NamedTuple):
    """Frames of the segments in the accepted state, from which material points are carried.

    Attributes:
        tangent: direction of each segment, shape [nodes + clamps, 3].
        director: material director before its rotation about the segment, shape [nodes + clamps, 3].
        turn: relative turn at the vertex ahead of each segment [rad], shape [nodes].
        per_radius: 1/radius at each node [1/mm], shape [nodes].
    """

    tangent: np.ndarray
    director: np.ndarray
    turn: np.ndarray
    per_radius: np.ndarray


class Frames(Protocol):
    """Who knows the frames of the segments."""

    @property
    def material_view(self) -> FrameView:
        """Those of the accepted state."""
        ...
