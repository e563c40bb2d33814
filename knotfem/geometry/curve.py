"""Centrelines as smooth parametric curves, and interpolation of points by a spline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from knotfem.geometry.points import as_points
from knotfem.types import Array


class Curve(Protocol):
    """A smooth open parametric curve in space."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        ...

    @property
    def spans(self) -> Array:
        """Parameters that bound the smooth pieces of the curve, shape (pieces + 1,)."""
        ...

    def __call__(self, parameter: ArrayLike) -> Array:
        """Points at the parameters, shape (..., 3)."""
        ...

    def derivative(self, parameter: ArrayLike) -> Array:
        """First derivative with respect to the parameter, shape (..., 3)."""
        ...


@dataclass(frozen=True)
class NaturalSpline:
    """Natural cubic spline through points, whose parameter is the cumulative chord length.

    Attributes:
        spline: of the three coordinates.
    """

    spline: CubicSpline

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.spline.x[0]), float(self.spline.x[-1])

    @property
    def spans(self) -> Array:
        """Parameters of the points, shape (n,)."""
        return self.spline.x

    def __call__(self, parameter: ArrayLike) -> Array:
        """Points at the parameters, shape (..., 3)."""
        return self.spline(np.asarray(parameter, dtype=np.float64))

    def derivative(self, parameter: ArrayLike) -> Array:
        """First derivative with respect to the parameter, shape (..., 3)."""
        return self.spline(np.asarray(parameter, dtype=np.float64), 1)


def interpolate(points: ArrayLike) -> NaturalSpline:
    """Interpolate points by the natural cubic spline over the cumulative chord length.

    Args:
        points: shape (n, 3), n >= 2.

    Raises:
        InputError: points that are not finite, too few, or repeated.
    """
    array = as_points(points)
    chords = np.linalg.norm(np.diff(array, axis=0), axis=1)
    return NaturalSpline(CubicSpline(np.concatenate([[0.0], np.cumsum(chords)]), array, bc_type="natural"))
