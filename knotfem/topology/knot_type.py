"""Knot type of an open or closed curve by its Jones polynomial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.points import as_points
from knotfem.topology.closure import EndDirection, close
from knotfem.topology.diagram import Diagram, diagram
from knotfem.topology.jones import Laurent, jones
from knotfem.topology.knot_table import names
from knotfem.topology.reidemeister import reduce
from knotfem.topology.simplify import simplify
from knotfem.types import Array

VIEWS = 12
"""Number of projections of the simplified curve, of which that with the fewest crossings is used."""


@dataclass(frozen=True)
class KnotType:
    """Knot type as far as the Jones polynomial tells.

    Attributes:
        name: of the simplest knot with this polynomial, such as "3_1" or "3_1 # mirror 3_1"; "unnamed" if it is not in
            the table. Knots of ten and more crossings may share the polynomial of a simpler one, as 10_132 does that of
            5_1.
        handedness: "right", "left", or "" if the polynomial equals that of the mirror image or has no name. Right means
            mostly positive exponents; for a composite knot the first factor decides.
        jones: Jones polynomial in t; t + t^3 - t^4 for the right-handed trefoil.
        crossings: number of crossings of the reduced diagram, an upper bound of the crossing number.
    """

    name: str
    handedness: str
    jones: Laurent
    crossings: int

    def __str__(self) -> str:
        """Text such as `3_1, right-handed` or `unnamed (1 - t + t^3)`."""
        if self.name == "unnamed":
            return f"unnamed ({self.jones})"
        return f"{self.name}, {self.handedness}-handed" if self.handedness else self.name


def simplest_diagram(polygons: Sequence[Array]) -> Diagram:
    """Reduced diagram of a link with the fewest crossings over a fixed set of projections.

    The polygons are simplified first. The directions of projection are those of a Fibonacci lattice on a hemisphere.

    Args:
        polygons: closed, each of shape (n, 3), the first point not repeated.
    """
    simple = simplify(polygons)
    best: Diagram | None = None
    for k in range(VIEWS):
        z = 1.0 - (k + 0.5) / VIEWS
        angle = 2.399963 * k
        across = (1.0 - z * z) ** 0.5
        found = reduce(diagram(simple, (across * np.cos(angle), across * np.sin(angle), z)))
        if best is None or len(found.crossings) < len(best.crossings):
            best = found
        if len(best.crossings) < 3:
            break
    assert best is not None
    return best


def knot_type(
    points: ArrayLike, ends: tuple[EndDirection, EndDirection] = ("tangent", "tangent"), *, closed: bool = False
) -> KnotType:
    """Knot type of a polyline.

    Args:
        points: shape (n, 3), beginning with the loading end.
        ends: how the first and the last end are continued before they are joined far away; see `closure.close`. If an
            end lies inside a loop, the knot type depends on this, so keep it fixed when several states are compared.
        closed: whether the polyline is a closed polygon, its first point not repeated; `ends` has no meaning then.

    Raises:
        InputError: points that are not finite, too few or repeated, or an unknown or zero direction.
    """
    polygon = as_points(points, fewest=3) if closed else close(points, ends)
    simplest = simplest_diagram([polygon])
    polynomial = jones(simplest)
    name, handedness = names().get(polynomial, ("unnamed", ""))
    return KnotType(name, handedness, polynomial, len(simplest.crossings))
