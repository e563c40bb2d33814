"""Rigid surfaces that rods touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from knotfem.compiled import kernel
from knotfem.geometry.rotation import across, unit


class Foot(NamedTuple):
    """Closest points of a rigid surface.

    Attributes:
        distance: signed, positive outside [mm], shape [n].
        normal: outward unit normal there, the gradient of the distance, shape [n, 3].
        turn: derivative of the normal by the point, the Hessian of the distance [1/mm], shape [n, 3, 3].
    """

    distance: np.ndarray
    normal: np.ndarray
    turn: np.ndarray


class RigidSurface(Protocol):
    """A smooth rigid surface, given by the signed distance from it.

    An own one needs these two methods; any class that has them will do.
    """

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance [mm] of points, shape [n, 3], positive outside; shape [n]."""
        ...

    def foot(self, points: np.ndarray) -> Foot:
        """Distance, normal and its derivative at points, shape [n, 3]."""
        ...


@kernel(error_model="numpy")
def _cylinder_distance(
    points: np.ndarray, origin: np.ndarray, axis: np.ndarray, radius: float, distance: np.ndarray
) -> None:
    n = np.empty(3)
    for s in range(points.shape[0]):
        distance[s] = _radial(points[s], origin, axis, n) - radius


@kernel(inline="always", error_model="numpy")
def _radial(p: np.ndarray, origin: np.ndarray, axis: np.ndarray, n: np.ndarray) -> float:
    """Distance of p from the axis; n (3) is the outward unit vector."""
    for i in range(3):
        n[i] = p[i] - origin[i]
    across(axis, n, n)
    return unit(n, n)


@kernel(error_model="numpy")
def _cylinder_foot(
    points: np.ndarray, origin: np.ndarray, axis: np.ndarray, radius: float, distance: np.ndarray, normal: np.ndarray,
    turn: np.ndarray,
) -> None:  # fmt: skip
    for s in range(points.shape[0]):
        n = normal[s]
        rho = _radial(points[s], origin, axis, n)
        distance[s] = rho - radius
        for i in range(3):
            for j in range(3):
                turn[s, i, j] = ((1.0 if i == j else 0.0) - n[i] * n[j] - axis[i] * axis[j]) / rho


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A circular cylinder without ends.

    A point at the distance rho from the axis has the distance rho - R from the surface, with the radial unit vector n
    as its gradient and (I - n n^T - a a^T)/rho as its Hessian.

    Attributes:
        origin: a point of its axis [mm], shape [3].
        axis: unit vector, shape [3].
        radius: R [mm].
    """

    origin: np.ndarray
    axis: np.ndarray
    radius: float

    def distance(self, points: np.ndarray) -> np.ndarray:
        """See `RigidSurface`."""
        distance = np.empty(len(points))
        _cylinder_distance(points, self.origin, self.axis, self.radius, distance)
        return distance

    def foot(self, points: np.ndarray) -> Foot:
        """See `RigidSurface`."""
        foot = Foot(np.empty(len(points)), np.empty((len(points), 3)), np.empty((len(points), 3, 3)))
        _cylinder_foot(points, self.origin, self.axis, self.radius, *foot)
        return foot

    def describe(self) -> str:
        """Its figures with units."""
        return f"diameter {2.0 * self.radius:g} mm"


def make_cylinder(point: np.ndarray, axis: np.ndarray, radius: float) -> Cylinder:
    """A cylinder with an axis of any length."""
    direction = np.array(axis, dtype=float)
    return Cylinder(np.array(point, dtype=float), direction / np.linalg.norm(direction), radius)
