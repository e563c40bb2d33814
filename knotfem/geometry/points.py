"""Polylines: the one place that says what a list of points must be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.errors import InputError

Array = NDArray[np.float64]

FEWEST_POINTS = 4
"""A space curve with curvature and torsion needs four points; fewer are taken for a mistake."""


def as_points(points: ArrayLike, *, fewest: int = 2, file: str | Path | None = None) -> Array:
    """Return the points as contiguous floats after checking them.

    Args:
        points: shape (n, 3).
        fewest: smallest n accepted.
        file: named in the message of an error.

    Returns:
        Shape (n, 3).

    Raises:
        InputError: wrong shape, a number that is not finite, too few points, or a point repeated in direct succession.
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


def unit(vector: ArrayLike) -> Array:
    """Return the vector, shape (3,), at length 1.

    Raises:
        InputError: its length is zero or not finite.
    """
    array = np.asarray(vector, dtype=np.float64)
    length = float(np.linalg.norm(array)) if array.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise InputError("not a direction", found=array.tolist(), expected="three finite numbers, not all zero")
    return array / length
