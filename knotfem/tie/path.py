"""What every mapping of the centreline offers: vertices and edge stretches at any mapping time."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from knotfem.errors import InputError

Array = NDArray[np.float64]


class CentrelinePath(Protocol):
    """A continuous move of the centreline from a straight rod (t = 0) into the knot (t = 1).

    Attributes:
        kind: name of the mapping, as `make_path` takes it.
        chord: length h of every edge of the straight rod, mm.
    """

    @property
    def kind(self) -> str: ...

    @property
    def chord(self) -> float: ...

    def at(self, t: float) -> Array:
        """Returns the centreline vertices at mapping time t in [0, 1], shape (n + 1, 3), mm."""
        ...

    def stretch(self, t: float) -> Array:
        """Returns edge length over h at mapping time t, shape (n,)."""
        ...

    def describe(self) -> dict[str, Any]:
        """Returns what the mapping is and how far it stretches, fit for JSON."""
        ...


def check_target(target: ArrayLike) -> Array:
    """Returns the target vertices as a float array of their own, shape (n + 1, 3), mm.

    Raises:
        InputError: wrong shape, fewer than three vertices, values that are not finite, coinciding neighbours.
    """
    points = np.array(target, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 3:
        raise InputError("wrong shape of the target centreline", found=points.shape, expected="(n + 1, 3) with n >= 2")
    if not np.isfinite(points).all():
        raise InputError("the target centreline has coordinates that are not finite")
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if chords.min() <= 1e-9 * chords.mean():
        raise InputError(
            "neighbouring vertices of the target centreline coincide", found=f"vertices {chords.argmin()} and next"
        )
    return points


def check_time(t: float) -> float:
    """Returns the mapping time.

    Raises:
        InputError: t is outside [0, 1].
    """
    if not 0.0 <= t <= 1.0:
        raise InputError("mapping time out of range", found=t, expected="0 <= t <= 1")
    return float(t)


def check_direction(direction: ArrayLike) -> Array:
    """Returns the direction as a unit vector, shape (3,).

    Raises:
        InputError: not three finite numbers, or zero.
    """
    vector = np.array(direction, dtype=float)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not np.linalg.norm(vector) > 0.0:
        raise InputError(
            "wrong direction of the straight rod",
            found=direction,
            expected="three finite numbers, not all zero",
        )
    return vector / np.linalg.norm(vector)


def check_start(start: ArrayLike) -> Array:
    """Returns the place of the straight rod's first vertex, shape (3,), mm.

    Raises:
        InputError: not three finite numbers.
    """
    place = np.array(start, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError("wrong start of the straight rod", found=start, expected="three finite numbers")
    return place


def mean_chord(points: Array) -> float:
    """Returns the mean edge length h of a polyline (n + 1, 3), mm: the edge length of the rod it is tied from."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())


def straight_rod(target: Array, direction: Array, start: ArrayLike | None = None) -> Array:
    """Returns the straight rod that becomes the target: X_i = X_0 + i h E.

    Args:
        target: vertices of the target, shape (n + 1, 3), mm; its mean chord is h.
        direction: unit vector E, shape (3,).
        start: X_0, shape (3,), mm; by default the rod's middle lies at the target's centroid.

    Returns:
        Vertices with equal chords, shape (n + 1, 3), mm.
    """
    arclength = mean_chord(target) * np.arange(len(target))
    first = target.mean(axis=0) - arclength.mean() * direction if start is None else check_start(start)
    return first + arclength[:, None] * direction


def polyline_stretch(points: Array, chord: float) -> Array:
    """Returns edge length / chord of a polyline (n + 1, 3), shape (n,)."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1) / chord
