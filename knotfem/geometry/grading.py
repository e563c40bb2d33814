"""Slices that are short where a rod is to bend tightly, and long where it stays straight."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from knotfem.geometry.measures import arclength, curvature
from knotfem.geometry.slices import Slices
from knotfem.types import Array

GROWTH = 1.15
"""Largest ratio of the lengths of neighbouring elements."""
_FINE = 32
"""Points per shortest element at which lengths are found."""


def graded_slices(points: Array, length: float, longest: float, angle: float, reach: float, order: int = 1) -> Slices:
    """Slices within which a curve turns by no more than an angle, wherever the rod slides along it.

    A slice is no longer than the angle over the largest curvature within reach of it, so that material which the rod's
    motion carries into a bend is fine enough there. Lengths grow from element to element by a factor of `GROWTH` at the
    most, and all are shrunk alike so that a whole number of elements fills the rod.

    Args:
        points: of the curve in near equal chords, shape [n, 3]; scaled to the rod's length.
        length: of the rod [mm].
        longest: slice [mm].
        angle: by which the curve turns in a slice at most [rad].
        reach: along the rod [mm].
        order: slices of one length that an element spans.
    """
    coarse = arclength(points)
    scale = length / coarse[-1]
    width = 2 * int(np.ceil(reach * (len(points) - 1) / length)) + 1
    bent = maximum_filter1d(curvature(points) / scale, min(width, 2 * len(points) - 1), mode="nearest")
    wanted = order * np.minimum(longest, angle / np.maximum(bent, angle / longest))
    s = np.linspace(0.0, length, 1 + int(np.ceil(_FINE * length / wanted.min())))
    element = _slowly_growing(s, np.interp(s, scale * coarse, wanted))
    number = np.concatenate([[0.0], np.cumsum(0.5 * (1.0 / element[1:] + 1.0 / element[:-1]) * np.diff(s))])
    count = int(np.ceil(number[-1] * (1.0 - 1e-9)))
    borders = np.interp(np.linspace(0.0, number[-1], count + 1), number, s)
    return Slices(np.repeat(np.diff(borders) / order, order))


def _slowly_growing(s: Array, lengths: Array) -> Array:
    """The largest lengths below the given ones that change along the rod by no more than ln `GROWTH` per length."""
    rise = np.log(GROWTH) * s
    forward = np.minimum.accumulate(lengths - rise) + rise
    backward = np.minimum.accumulate((lengths + rise)[::-1])[::-1] - rise
    return np.minimum(forward, backward)
