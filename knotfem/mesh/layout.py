"""Layouts of cross-sections: how many quadrilaterals a disc can be meshed with, and which layout has so many.

All have the eight-fold mirror symmetry of the square, so that a rod bends alike about both axes and a knot and its
mirror image behave alike: a square block around the axis inside rings. Of rings there are enough to turn the square
into a disc, and so few that no quadrilateral is more than 3.6 times as large as another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import isqrt

LARGEST = 500
"""Quadrilaterals of a section, more than four times those of the finest that ships."""


@dataclass(frozen=True)
class Layout:
    """A core block of `across` x `across` quadrilaterals, with or without its four corners, inside rings of 4 `across`.

    Attributes:
        across: quadrilaterals along a side of the core block, even.
        corners: whether the block keeps its four corner quadrilaterals.
        rings: rings of quadrilaterals around the block.
    """

    across: int
    corners: bool
    rings: int

    @property
    def elements(self) -> int:
        """Number of quadrilaterals."""
        return self.across**2 - (0 if self.corners else 4) + 4 * self.across * self.rings


@cache
def layouts() -> dict[int, Layout]:
    """Layouts by their number of quadrilaterals, ascending; of two the one with more nodes on the circle."""
    found = {layout.elements: layout for layout in _all() if layout.elements <= LARGEST}
    return dict(sorted(found.items()))


def nearest_count(elements: int) -> int:
    """The number of quadrilaterals that a section can have next to the one asked for; of two the larger."""
    return min(layouts(), key=lambda count: (abs(count - elements), -count))


def _all() -> Iterator[Layout]:
    """From few to many nodes on the circle."""
    yield from (Layout(2, True, rings) for rings in range(3))
    for across in range(4, isqrt(LARGEST) + 1, 2):
        for rings in range(1, across // 2 + 2):
            yield Layout(across, True, rings)
            yield Layout(across, False, rings)
