"""What rods are tied into, told in several ways, so that an end that merely swings does not change it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.geometry.frames import tangents
from knotfem.scene.effects import Cylinder
from knotfem.topology.knot_type import KnotType, knot_type
from knotfem.topology.linking import Ends, winding_angle
from knotfem.topology.words import come_undone

LEAST_UNWINDING = 0.5 * math.pi
"""A hitch whose rod has turned by less about the obstacle is what it was."""


def turns(winding: float) -> int:
    """Whole turns of a winding angle [rad]."""
    return round(winding / (2.0 * math.pi))


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
        return tuple(turns(winding) for winding in self.windings)

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

    def undone(self, before: Sequence[RodTies], lines: Sequence[np.ndarray]) -> str:
        """What is no longer tied as it was, in words; "" for nothing.

        Args:
            before: ties that they had.
            lines: centrelines now [mm], shape [n, 3] each.
        """
        for rod, (old, line) in enumerate(zip(before, lines, strict=True)):
            found = self._knot_undone(rod, old, line) if old.knotted else self._hitch_undone(old, line)
            if found:
                return found
        return ""

    def _of_rod(self, rod: int, line: np.ndarray) -> RodTies:
        kinds = list(self._kinds(rod, line))
        names, jones = tuple(kind.name for kind in kinds), tuple(str(kind.jones) for kind in kinds)
        return RodTies(self.names[rod], names, jones, self._windings(line))

    def _kinds(self, rod: int, line: np.ndarray) -> Iterator[KnotType]:
        t = tangents(line)
        return (knot_type(line, ends) for ends in (*self.fixed[rod], (-t[0], t[-1])))

    def _windings(self, line: np.ndarray) -> tuple[float, ...]:
        return tuple(winding_angle(line, obstacle.point, obstacle.axis) for obstacle in self.obstacles)

    def _knot_undone(self, rod: int, old: RodTies, line: np.ndarray) -> str:
        """The first closure that is as it was decides; the others are not computed then."""
        became: list[str] = []
        for jones, kind in zip(old.jones, self._kinds(rod, line), strict=True):
            if str(kind.jones) == jones:
                return ""
            became.append(kind.name)
        if all(name != "unknot" for name in became):
            return f"the {old.knots[0]} of {old.name} has become {became[0]}"
        return come_undone(old.knots[0], old.name)

    def _hitch_undone(self, old: RodTies, line: np.ndarray) -> str:
        for a, b in zip(old.windings, self._windings(line), strict=True):
            if turns(a) not in (0, turns(b)) and abs(a - b) > LEAST_UNWINDING:
                return come_undone("hitch", old.name)
        return ""


def stored(ties: Sequence[RodTies]) -> list[dict[str, Any]]:
    """For a checkpoint."""
    return [dict(vars(rod)) for rod in ties]


def restored(values: Sequence[dict[str, Any]]) -> list[RodTies]:
    """From a checkpoint."""
    return [RodTies(v["name"], tuple(v["knots"]), tuple(v["jones"]), tuple(map(float, v["windings"]))) for v in values]
