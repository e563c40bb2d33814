"""Linear mapping, in which every vertex moves on a straight line; it compresses the rod strongly on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.slices import Slices
from knotfem.tie.direction import resolve_direction
from knotfem.tie.extremes import extreme_stretches
from knotfem.tie.path import CentrelinePath, check_slices, check_target, check_time, straight_rod, stretch_range
from knotfem.types import Array


@dataclass(frozen=True, kw_only=True)
class LinearPath(CentrelinePath):
    """x_i(t) = X_i + t u_i.

    Source: Aymon et al., Extreme Mech. Lett. 81, 102413 (2025), Eq. (A.2).

    Attributes:
        straight: X, the straight rod, shape (n + 1, 3), mm.
        target: x = X + u, shape (n + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        slices: edges of the straight rod, mm.
        kind: name of the mapping.
    """

    straight: Array
    target: Array
    direction: Array
    slices: Slices
    kind: str = "linear"

    def at(self, t: float) -> Array:
        """Return the vertices at mapping time t, shape (n + 1, 3), mm."""
        t = check_time(t)
        return (1.0 - t) * self.straight + t * self.target

    def describe(self) -> dict[str, Any]:
        """Return the direction and the exact extreme stretches over all times."""
        edges = np.diff(self.target, axis=0) / self.slices.lengths[:, None]
        return {
            "kind": self.kind,
            "direction": self.direction.tolist(),
            **stretch_range(extreme_stretches(self.direction, edges, np.zeros_like(edges))[1]),
        }


def linear_path(
    target: ArrayLike,
    *,
    direction: str | ArrayLike = (0.0, 0.0, 1.0),
    start: ArrayLike | None = (0.0, 0.0, 0.0),
    slices: Slices | None = None,
) -> LinearPath:
    """Linear mapping from a straight rod, by default X_i = i h e_z, to the knot.

    Args:
        target: vertices of the knotted centreline, shape (n + 1, 3), mm.
        direction: of the straight rod, or "best" for that whose largest angle to the target's edges is smallest. It
            compresses the rod least, since the stretch of an edge at t = 1/2 is cos(angle / 2).
        start: position of the straight rod's first vertex, shape (3,), mm; None puts the rod's middle at the target's
            centroid.
        slices: edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Raises:
        InputError: the target, the direction or the start is not valid.
    """
    points = check_target(target)
    unit, edges = resolve_direction(direction, points), check_slices(slices, points)
    return LinearPath(straight=straight_rod(points, unit, edges, start), target=points, direction=unit, slices=edges)
