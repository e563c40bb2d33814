"""Knot type of an open curve by several ways of closing it, which may disagree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.points import as_points
from knotfem.topology.knot_type import KnotType, knot_type
from knotfem.topology.linking import Ends
from knotfem.types import Array

RANDOM = 10
"""Random directions along which both ends of a curve are continued, always the same ones."""
SURE = 2
"""Ways that decide alone where they agree: the first two."""


@cache
def random_directions() -> tuple[Array, ...]:
    """Unit vectors, distributed evenly over all directions, shape (3,) each."""
    vectors = np.random.default_rng(20270).normal(size=(RANDOM, 3))
    return tuple(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def ways_of(tangent: Ends, outward: Ends) -> list[Ends]:
    """Ways of continuing the two ends of a curve: along its tangents, outwards, and both along each random direction.

    Args:
        tangent: outward tangents of the first and the last end, each of shape (3,).
        outward: directions away from the middle, likewise.
    """
    return [tangent, outward, *((direction, direction) for direction in random_directions())]


BY = " (by "
"""What follows the name of a knot where closures disagree."""


@dataclass(frozen=True)
class Closures:
    """Knot types of one open curve.

    Attributes:
        kinds: for each way of closing it, that along its tangents first.
    """

    kinds: tuple[KnotType, ...]

    @property
    def most(self) -> KnotType:
        """The knot type of most closures; of two that are as many, that which comes first."""
        counts = Counter(kind.jones for kind in self.kinds)
        return max(self.kinds, key=lambda kind: counts[kind.jones])

    @property
    def counts(self) -> dict[str, int]:
        """Number of closures by the name of the knot, the most frequent first."""
        return dict(Counter(kind.name for kind in self.kinds).most_common())

    def __str__(self) -> str:
        """Name of the knot, and where closures disagree, how many are of it and what the others say."""
        most, total = self.most, len(self.kinds)
        same = sum(kind.jones == most.jones for kind in self.kinds)
        if same == total:
            return most.name
        others = Counter(kind.name for kind in self.kinds if kind.jones != most.jones).most_common()
        said = ", ".join(f"{name} by {count}" for name, count in others)
        along = "" if self.kinds[0].jones == most.jones else f", {self.kinds[0].name} along its tangents"
        return f"{most.name}{BY}{same} of {total} closures; {said}{along})"


def name_of(said: str) -> str:
    """The knot of most closures, in the words of a `Closures`."""
    return said.partition(BY)[0]


def closures_of(points: ArrayLike, ways: Sequence[Ends]) -> Closures:
    """Knot types of an open curve.

    Args:
        points: shape (n, 3).
        ways: of continuing its ends; keep them fixed when several states are compared.

    Raises:
        InputError: points that `as_points` refuses, or a zero direction.
    """
    return Closures(tuple(knot_type(points, way) for way in ways))


def is_knotted(points: ArrayLike, ways: Sequence[Ends]) -> bool:
    """Whether at least half of the closures of an open curve are knotted.

    Where the first two are, the others are not computed: one closure alone may be wrong, two of them rarely are.

    Args:
        points: shape (n, 3).
        ways: of continuing its ends.
    """
    first = [knot_type(points, way).name != "unknot" for way in ways[:SURE]]
    if all(first):
        return True
    others = sum(knot_type(points, way).name != "unknot" for way in ways[SURE:])
    return 2 * (sum(first) + others) >= len(ways)


def check_smoothing(drawn: ArrayLike, smoothed: ArrayLike, file: str | Path | None = None) -> None:
    """Refuse a smoothing that has changed the knot, as far as the Jones polynomial shows.

    Both curves are closed in the directions of the smoothed one: the ends of measured points point anywhere. They are
    the same knot if they are so closed along the tangents, or else if most of their closures are.

    Args:
        drawn: vertices before smoothing, shape (n, 3).
        smoothed: vertices after smoothing, shape (m, 3).
        file: named in the message.

    Raises:
        InputError: the two curves have different Jones polynomials.
    """
    x, y = as_points(drawn), as_points(smoothed)
    middle = 0.5 * (y.min(axis=0) + y.max(axis=0))
    ways = ways_of((y[0] - y[1], y[-1] - y[-2]), (y[0] - middle, y[-1] - middle))
    if knot_type(x, ways[0]).jones == knot_type(y, ways[0]).jones:
        return
    before, after = closures_of(x, ways), closures_of(y, ways)
    if before.most.jones != after.most.jones:
        problem = "smoothing has changed the knot; take fewer iterations"
        raise InputError(problem, file=file, found=str(after.most), expected=str(before.most))
