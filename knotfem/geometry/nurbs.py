"""Non-uniform rational B-spline (NURBS) curves, with the knots that Blender gives them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from knotfem.errors import InputError
from knotfem.types import Array


@dataclass(frozen=True)
class Nurbs:
    """A non-uniform rational B-spline curve.

    Attributes:
        degree: of the polynomials, the order minus one.
        points: control points, shape (n, 3).
        weights: of the control points, positive, shape (n,).
        knots: non-decreasing, shape (n + degree + 1,).

    Raises:
        InputError: any of these is out of range, of the wrong shape or not finite.
    """

    degree: int
    points: Array
    weights: Array
    knots: Array

    def __post_init__(self) -> None:
        n = len(self.points)
        if self.degree < 1:
            raise InputError("NURBS degree is too low", found=self.degree, expected="at least 1")
        if n < self.degree + 1:
            raise InputError("too few control points", found=n, expected=f"at least {self.degree + 1}")
        if self.points.shape != (n, 3) or self.weights.shape != (n,):
            raise InputError("control points have the wrong shape", found=self.points.shape, expected="(n, 3)")
        if not (np.isfinite(self.points).all() and np.isfinite(self.weights).all() and np.isfinite(self.knots).all()):
            raise InputError("a control point, weight or knot is not finite")
        if not (self.weights > 0).all():
            raise InputError("a NURBS weight is not positive", found=float(self.weights.min()), expected="above 0")
        if self.knots.shape != (n + self.degree + 1,):
            expected = f"{n + self.degree + 1} (control points + degree + 1)"
            raise InputError("wrong number of knots", found=len(self.knots), expected=expected)
        if (np.diff(self.knots) < 0).any() or not self.knots[self.degree] < self.knots[n]:
            raise InputError("knots do not rise", found=self.knots.tolist(), expected="a non-decreasing list")

    @cached_property
    def _homogeneous(self) -> BSpline:
        return BSpline(self.knots, np.column_stack([self.points * self.weights[:, None], self.weights]), self.degree)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter of the curve."""
        return float(self.knots[self.degree]), float(self.knots[len(self.points)])

    @property
    def spans(self) -> Array:
        """Parameters that bound the rational pieces of the curve, shape (pieces + 1,)."""
        return np.unique(np.clip(self.knots, *self.domain))

    def __call__(self, parameter: ArrayLike) -> Array:
        """Points at the parameters, shape (..., 3)."""
        value = self._homogeneous(np.asarray(parameter, dtype=np.float64))
        return value[..., :3] / value[..., 3:]

    def derivative(self, parameter: ArrayLike) -> Array:
        """First derivative with respect to the parameter, shape (..., 3)."""
        t = np.asarray(parameter, dtype=np.float64)
        value, slope = self._homogeneous(t), self._homogeneous(t, 1)
        return (slope[..., :3] - value[..., :3] / value[..., 3:] * slope[..., 3:]) / value[..., 3:]


def blender_knots(count: int, order: int, *, endpoint: bool, bezier: bool) -> Array:
    """Knots of an open Blender NURBS spline (its `use_endpoint_u` and `use_bezier_u` options).

    Args:
        count: number of control points.
        order: Blender's `order_u`, degree + 1.
        endpoint: the curve begins and ends at its first and last control points.
        bezier: inner knots are repeated order - 1 times, so that the curve is a sequence of Bezier arcs.

    Returns:
        Shape (count + order,).
    """
    repeat = order - 1 if bezier else 1
    head = order if endpoint else (min(2, repeat) if bezier else 1)
    index = np.arange(count + order)
    if endpoint:
        index = np.minimum(index, count)
    return np.where(index < head, 0, 1 + (index - head) // repeat).astype(np.float64)
