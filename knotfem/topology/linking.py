"""Whether two open rods are laced into each other, and the link that they form when both are closed far away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from knotfem.geometry.points import Array, as_points
from knotfem.topology.closure import FAR, close
from knotfem.topology.jones import Laurent, jones
from knotfem.topology.knot_type import simplest_diagram

Ends = tuple[ArrayLike, ArrayLike]
"""Directions in which the first and the last end of a rod go on, each of shape (3,)."""


@dataclass(frozen=True)
class Lacing:
    """Two open rods.

    Attributes:
        jones: of the link that they form with all ends continued and each rod closed by itself.
        laced: whether they differ from two rods laid straight between the same ends, each with its own knot.
    """

    jones: Laurent
    laced: bool


def lacing(rods: tuple[ArrayLike, ArrayLike], ends: tuple[Ends, Ends]) -> Lacing:
    """Compare two rods with two that are straight between the same ends.

    Rods that merely lie on one another are not laced; a clasp of two bights, a sheet bend and a reef knot of two ropes
    are. The closing arcs are those of both links and lie outside the rods, so the comparison does not depend on them.

    Args:
        rods: nodes, shape (n, 3) each.
        ends: of either rod; keep them fixed when states are to be compared.

    Raises:
        InputError: points or directions that are none.
    """
    first, second = as_points(rods[0]), as_points(rods[1])
    both = np.concatenate([first, second])
    centre = 0.5 * (both.min(axis=0) + both.max(axis=0))
    radius = FAR * float(np.linalg.norm(both - centre, axis=1).max())

    def closed(x: Array, which: int) -> Array:
        return close(x, ends[which], (centre, (1.0 + 0.1 * which) * radius))

    own = jones(simplest_diagram([closed(first, 0)])) * jones(simplest_diagram([closed(second, 1)]))
    link = jones(simplest_diagram([closed(first, 0), closed(second, 1)]))
    straight = jones(simplest_diagram([closed(first[[0, -1]], 0), closed(second[[0, -1]], 1)]))
    return Lacing(link, link != own * straight)
