"""What rods are tied into, told in several ways, so that an end that merely swings does not change it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.geometry.frames import tangents
from knotfem.scene.effects import Cylinder
from knotfem.topology.knot_type import knot_type
from knotfem.topology.linking import Ends, winding_angle
from knotfem.topology.words import come_undone

LEAST_UNWINDING = 0.5 * math.pi
"""A hitch whose rod has turned by less about the obstacle is what it was."""


@dataclass(frozen=True)
class RodTies:
    """What one rod is tied into.

    Attributes:
        name: of the rod.
        knots: name of the knot for each way of continuing the ends.
        jones: its Jones polynomial, likewise.
        windings: angle by which the rod turns about each obstacle [rad].
    """

    name: str
    knots: tuple[str, ...]
    jones: tuple[str, ...]
    windings: tuple[float, ...]

    @property
    def knotted(self) -> bool:
        """Whether it is a knot, each way of continuing the ends."""
        return all(name != "unknot" for name in self.knots)

    @property
    def linking(self) -> tuple[int, ...]:
        """Linking number with each obstacle."""
        return tuple(round(winding / (2.0 * math.pi)) for winding in self.windings)

    @property
    def trivial(self) -> bool:
        """Whether topology does not hold it."""
        return not self.knotted and not any(self.linking)


class TieReader:
    """Reads what rods are tied into.

    An end is continued in two fixed directions, along the rod and away from the middle as it was tied, and along the
    rod as it is now. Each of these lines may sweep over a strand while the end itself is nowhere near; only a strand
    that the end passes changes all three.

    Args:
        names: of the rods.
        fixed: the two fixed directions of both ends of each rod.
        obstacles: cylinders of the scene.
    """

    def __init__(self, names: Sequence[str], fixed: Sequence[Sequence[Ends]], obstacles: Sequence[Cylinder]) -> None:
        self.names, self.fixed, self.obstacles = names, fixed, obstacles

    def read(self, lines: Sequence[np.ndarray]) -> list[RodTies]:
        """Ties of all rods.

        Args:
            lines: their centrelines [mm], shape [n, 3] each.
        """
        return [self._of_rod(rod, line) for rod, line in enumerate(lines)]

    def _of_rod(self, rod: int, line: np.ndarray) -> RodTies:
        t = tangents(line)
        kinds = [knot_type(line, ends) for ends in (*self.fixed[rod], (-t[0], t[-1]))]
        windings = tuple(winding_angle(line, obstacle.point, obstacle.axis) for obstacle in self.obstacles)
        names, jones = tuple(kind.name for kind in kinds), tuple(str(kind.jones) for kind in kinds)
        return RodTies(self.names[rod], names, jones, windings)


def undone(before: Sequence[RodTies], now: Sequence[RodTies]) -> str:
    """What is no longer tied as it was, in words; "" for nothing."""
    for old, new in zip(before, now, strict=True):
        if old.knotted:
            if all(a != b for a, b in zip(old.jones, new.jones, strict=True)):
                became = new.knots[0] if new.knotted else ""
                knot = old.knots[0]
                return f"the {knot} of {old.name} has become {became}" if became else come_undone(knot, old.name)
            continue
        for number, (a, b) in enumerate(zip(old.linking, new.linking, strict=True)):
            if a != b and a != 0 and abs(old.windings[number] - new.windings[number]) > LEAST_UNWINDING:
                return come_undone("hitch", old.name)
    return ""


def stored(ties: Sequence[RodTies]) -> list[dict[str, Any]]:
    """For a checkpoint."""
    return [dict(vars(rod)) for rod in ties]


def restored(values: Sequence[dict[str, Any]]) -> list[RodTies]:
    """From a checkpoint."""
    return [RodTies(v["name"], tuple(v["knots"]), tuple(v["jones"]), tuple(map(float, v["windings"]))) for v in values]
