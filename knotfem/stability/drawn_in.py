"""How far ends of rods are drawn into what holds them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from knotfem.stability.crossings import Crossing, restored, stored
from knotfem.stability.unit import Line

BEARING = 0.1
"""A crossing that carries less than this fraction of the largest normal force does not hold an end."""
REACH_OVER_DIAMETER = 2.0
"""A strand runs by less from one accepted step to the next."""


class DrawnIn:
    """Adds up by how much ends are drawn in.

    Of each end the bearing crossing nearest to it is looked at, in each accepted state anew. Its place on the other
    strand is a material point there, on an obstacle a point in space. How far the rod runs past that point in the next
    step is the change of the arclength at which it is closest to it. So neither a contact that wanders along both
    strands, nor a knot that moves or turns as a whole, nor an end that swings draws anything in.

    Args:
        rods: number of rods.
        diameter: of the thinnest rod [mm].

    Attributes:
        lengths: so far [mm], shape [rods, 2]: at the start of each rod, at its end.
    """

    def __init__(self, rods: int, diameter: float) -> None:
        self.lengths = np.zeros((rods, 2))
        self._reach = REACH_OVER_DIAMETER * diameter
        self._crossings: list[Crossing] = []
        self._lines: list[Line] = []

    def update(self, crossings: list[Crossing], lines: list[Line]) -> None:
        """Take an accepted state.

        Args:
            crossings: of it.
            lines: its centrelines.
        """
        least = BEARING * max((crossing.force for crossing in self._crossings), default=0.0)
        bearing = [crossing for crossing in self._crossings if crossing.force >= least]
        for rod in range(len(self.lengths)):
            sides = [(crossing, side) for crossing in bearing for side in (0, 1) if crossing.rods[side] == rod]
            if sides:
                first = min(sides, key=_place)
                last = max(sides, key=_place)
                self.lengths[rod] += -self._ran(*first, lines), self._ran(*last, lines)
        self._crossings, self._lines = crossings, lines

    def _ran(self, crossing: Crossing, side: int, lines: Sequence[Line]) -> float:
        """Towards the start of the rod of this side [mm]."""
        rod, place = crossing.rods[side], crossing.places[side]
        other, mark = crossing.rods[1 - side], crossing.places[1 - side]
        before, now = self._lines[rod], lines[rod]
        first = before.at(place) if other < 0 else self._lines[other].at(mark)
        second = first if other < 0 else lines[other].at(mark)
        return now.foot(second, place, self._reach) - before.foot(first, place, self._reach)

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        lines = [(line.points, line.arclengths) for line in self._lines]
        return {"lengths": self.lengths, "crossings": stored(self._crossings), "lines": lines}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self.lengths, self._crossings = np.array(state["lengths"]), restored(state["crossings"])
        self._lines = [Line(*arrays) for arrays in state["lines"]]


def _place(found: tuple[Crossing, int]) -> float:
    return found[0].places[found[1]]
