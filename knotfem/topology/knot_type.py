"""The type of a knot in an open rod: its ends extended, its diagram reduced, its Jones polynomial looked up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import as_points
from knotfem.topology.closure import EndDirection, close
from knotfem.topology.diagram import Diagram, diagram
from knotfem.topology.jones import Laurent, jones
from knotfem.topology.knot_table import names
from knotfem.topology.reidemeister import reduce
from knotfem.topology.simplify import simplify
from knotfem.types import Array

VIEWS = 12
"""Directions from which the simplified curve is looked at for the fewest crossings."""


@dataclass(frozen=True)
class KnotType:
    """What a closed curve is knotted into.

    Attributes:
        name: such as "3_1" or "3_1 # mirror 3_1", that of the simplest knot with this polynomial (knots of ten
            crossings and more may share it, as 10_132 does with 5_1); "unnamed" for one that is not in the table.
        handedness: "right", "left", or "" where the polynomial equals its mirror or has no name. Right leans to
            positive powers of t; of a composite, the first factor counts.
        jones: in t, right-handed trefoil = t + t^3 - t^4.
        crossings: of the reduced diagram, not less than the knot's crossing number.
    """

    name: str
    handedness: str
    jones: Laurent
    crossings: int

    def __str__(self) -> str:
        """Such as `3_1, right-handed` or `unnamed (1 - t + t^3)`."""
        if self.name == "unnamed":
            return f"unnamed ({self.jones})"
        return f"{self.name}, {self.handedness}-handed" if self.handedness else self.name


def simplest_diagram(polygons: Sequence[Array]) -> Diagram:
    """Simplify closed polygons and return the reduced diagram with the fewest crossings over a fixed set of views."""
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
    """Type of the knot in a polyline.

    Args:
        points: shape (n, 3), first = loading end.
        ends: where the first and the last end go on before they are joined far away: "tangent", "outward" (from the
            middle) or a vector of shape (3,). Where an end lies inside a loop the type depends on it, so keep it fixed
            when types are to be compared.
        closed: the polyline is a closed polygon without repetition of its first point; `ends` is not used.

    Raises:
        InputError: not finite, too few or repeated points, or a direction that is none.
    """
    polygon = as_points(points, fewest=3) if closed else close(points, ends)
    simplest = simplest_diagram([polygon])
    polynomial = jones(simplest)
    name, handedness = names().get(polynomial, ("unnamed", ""))
    return KnotType(name, handedness, polynomial, len(simplest.crossings))


def check_smoothing(drawn: ArrayLike, smoothed: ArrayLike, file: str | Path | None = None) -> None:
    """Refuse a smoothing that has changed the knot, as far as the Jones polynomial shows.

    Args:
        drawn: vertices before smoothing, shape (n, 3).
        smoothed: vertices after smoothing, shape (m, 3).
        file: named in the message.

    Raises:
        InputError: the two curves have different Jones polynomials.
    """
    before, after = knot_type(drawn), knot_type(smoothed)
    if before.jones != after.jones:
        problem = "smoothing has changed the knot; take fewer iterations"
        raise InputError(problem, file=file, found=after, expected=str(before))
