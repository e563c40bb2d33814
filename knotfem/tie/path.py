"""Interface of all mappings of the centreline, and checks of their arguments."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
from knotfem.types import Array


class CentrelinePath(ABC):
    """A continuous motion of the centreline from a straight rod, at mapping time t = 0, to the knot, at t = 1.

    Attributes:
        kind: name of the mapping, as `make_path` takes it.
        target: vertices of the knot, shape (n + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        slices: edges of the straight rod, mm.
    """

    kind: str
    target: Array
    direction: Array
    slices: Slices

    @abstractmethod
    def at(self, t: float) -> Array:
        """Return the vertices at mapping time t in [0, 1], shape (n + 1, 3), mm."""

    def stretch(self, t: float) -> Array:
        """Return the stretches at mapping time t, edge length over that of the straight rod, shape (n,)."""
        return np.linalg.norm(np.diff(self.at(t), axis=0), axis=1) / self.slices.lengths

    @abstractmethod
    def describe(self) -> dict[str, Any]:
        """Return properties of the mapping, among them its extreme stretches, as values that JSON can hold."""


def check_target(target: ArrayLike) -> Array:
    """Return a checked copy of the vertices of the target, shape (n + 1, 3), mm.

    Raises:
        InputError: wrong shape, fewer than three vertices, values that are not finite, or two successive vertices that
            coincide.
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
    """Return the mapping time after checking it.

    Raises:
        InputError: t is outside [0, 1].
    """
    if not 0.0 <= t <= 1.0:
        raise InputError("mapping time out of range", found=t, expected="0 <= t <= 1")
    return float(t)


def check_start(start: ArrayLike) -> Array:
    """Return the position of the straight rod's first vertex, shape (3,), mm.

    Raises:
        InputError: not three finite numbers.
    """
    place = np.array(start, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError("wrong start of the straight rod", found=start, expected="three finite numbers")
    return place


def check_slices(slices: Slices | None, points: Array) -> Slices:
    """Return the edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Args:
        slices: that are given.
        points: vertices of the target, shape (n + 1, 3), mm.

    Raises:
        InputError: not as many as the target has edges.
    """
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if slices is None:
        return Slices(np.full(chords.size, chords.mean()))
    if slices.count != chords.size:
        raise InputError("wrong number of slices", found=slices.count, expected=f"{chords.size}, as the target's edges")
    return slices


def straight_rod(target: Array, direction: Array, slices: Slices, start: ArrayLike | None = None) -> Array:
    """Return the straight rod from which the target is tied: X_i = X_0 + s_i E, s the arclength of the slices.

    Args:
        target: vertices of the target, shape (n + 1, 3), mm.
        direction: unit vector E, shape (3,).
        slices: edges of the straight rod, mm.
        start: X_0, shape (3,), mm; by default the rod's middle lies at the target's centroid.

    Returns:
        Vertices, shape (n + 1, 3), mm.
    """
    arclength = slices.arclength
    first = target.mean(axis=0) - arclength.mean() * direction if start is None else check_start(start)
    return first + arclength[:, None] * direction


def stretch_range(stretches: Array) -> dict[str, float]:
    """Return smallest and largest stretch and max |lambda - 1| by name.

    Args:
        stretches: of any shape.
    """
    return {
        "min_stretch": float(stretches.min()),
        "max_stretch": float(stretches.max()),
        "max_stretch_deviation": float(np.abs(stretches - 1.0).max()),
    }
