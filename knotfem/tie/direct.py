"""Mapping without intermediate states, for solvers that tie the knot in one step from a swept state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.slices import Slices
from knotfem.tie.direction import resolve_direction
from knotfem.tie.path import CentrelinePath, check_slices, check_target, straight_rod, stretch_range
from knotfem.types import Array


@dataclass(frozen=True, kw_only=True)
class DirectPath(CentrelinePath):
    """The straight rod at mapping time 0 and the knot at 1, and nothing between.

    Attributes:
        straight: the straight rod, shape (n + 1, 3), mm.
        target: the knot, shape (n + 1, 3), mm.
        direction: unit vector E of the straight rod, shape (3,).
        slices: edges of the straight rod, mm.
        kind: name of the mapping.
    """

    straight: Array
    target: Array
    direction: Array
    slices: Slices
    kind: str = "direct"

    def at(self, t: float) -> Array:
        """Return the straight rod at t = 0 or the knot at t = 1, shape (n + 1, 3), mm.

        Raises:
            InputError: any other mapping time.
        """
        if t not in (0.0, 1.0):
            raise InputError("the direct path has no intermediate states", found=t, expected="mapping time 0 or 1")
        return (self.straight if t == 0.0 else self.target).copy()

    def describe(self) -> dict[str, Any]:
        """Return the direction and the extreme stretches of the knot."""
        return {"kind": self.kind, "direction": self.direction.tolist(), **stretch_range(self.stretch(1.0))}


def direct_path(
    target: ArrayLike,
    *,
    direction: str | ArrayLike = (0.0, 0.0, 1.0),
    start: ArrayLike | None = (0.0, 0.0, 0.0),
    slices: Slices | None = None,
) -> DirectPath:
    """Mapping from a straight rod to the knot without intermediate states.

    Args:
        target: vertices of the knotted centreline, shape (n + 1, 3), mm.
        direction: of the straight rod, or "best".
        start: position of the straight rod's first vertex, shape (3,), mm; None puts the rod's middle at the target's
            centroid.
        slices: edges of the straight rod, mm; by default all as long as the mean chord of the target.

    Raises:
        InputError: the target, the direction or the start is not valid.
    """
    points = check_target(target)
    unit, edges = resolve_direction(direction, points), check_slices(slices, points)
    return DirectPath(straight=straight_rod(points, unit, edges, start), target=points, direction=unit, slices=edges)
