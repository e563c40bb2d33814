"""Polylines as arrays of points, checked in one place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.types import Array

FEWEST_POINTS = 4
"""Smallest number of points of a centreline: a space curve with curvature and torsion needs four."""


def as_points(points: ArrayLike, *, fewest: int = 2, file: str | Path | None = None) -> Array:
    """Return the points of a polyline as a contiguous array of floats after checking them.

    Args:
        points: shape (n, 3).
        fewest: smallest n that is accepted.
        file: named in the message of an error.

    Returns:
        Shape (n, 3).

    Raises:
        InputError: wrong shape, a number that is not finite, too few points, or two successive points closer than 1e-12
            of the extent.
    """
    array = np.ascontiguousarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError("points have the wrong shape", file=file, found=array.shape, expected="(n, 3)")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise InputError(f"point {bad[0] + 1} is not finite", file=file, found=array[bad[0]].tolist())
    if len(array) < fewest:
        raise InputError("too few points", file=file, found=len(array), expected=f"at least {fewest}")
    chords = np.linalg.norm(np.diff(array, axis=0), axis=1)
    extent = float(np.ptp(array, axis=0).max())
    repeated = np.flatnonzero(chords <= 1e-12 * extent)
    if repeated.size:
        i = int(repeated[0])
        raise InputError(f"points {i + 1} and {i + 2} are the same", file=file, found=array[i].tolist())
    return array
