"""How far rods run through their crossings, and which strands of the locking unit do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from knotfem.contact.report import ContactReport
from knotfem.stability.crossings import Crossing, crossings_of, matched, restored, stored
from knotfem.stability.unit import Line, LockingUnit, Strand, locking_unit

REACH_OVER_DIAMETER = 1.0
"""A crossing whose places on its strands differ by more from one accepted step to the next is another one."""


@dataclass(frozen=True)
class StrandSlip:
    """Length of a strand that has run through the crossings of the locking unit [mm].

    Attributes:
        strand: where it was at first.
        slip: positive where rod has run towards its start.
    """

    strand: Strand
    slip: float


@dataclass(frozen=True)
class UnitSlip:
    """Slips of the strands of a locking unit.

    Attributes:
        wrapping: of the wrapping strand.
        central: of each central one.
        angle: by which the wrapping strand turns [rad].
    """

    wrapping: StrandSlip
    central: tuple[StrandSlip, ...]
    angle: float

    @property
    def largest(self) -> float:
        """Largest size of a slip [mm]."""
        return max(abs(strand.slip) for strand in (self.wrapping, *self.central))

    @property
    def mode(self) -> str:
        """What runs further: "wrapping" or "central"."""
        central = max((abs(strand.slip) for strand in self.central), default=0.0)
        return "central" if central > abs(self.wrapping.slip) else "wrapping"

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        stored = [{**vars(found.strand), "slip": found.slip} for found in (self.wrapping, *self.central)]
        return {"strands": stored, "angle": self.angle}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> UnitSlip:
        """From a checkpoint."""
        wrapping, *central = (StrandSlip(Strand(v["rod"], v["first"], v["last"]), v["slip"]) for v in state["strands"])
        return cls(wrapping, tuple(central), state["angle"])


@dataclass
class Tracks:
    """Crossings of one state, followed through the states after it.

    Attributes:
        unit: locking unit of that state, or None.
        crossings: of that state.
        now: number of each in the present state; -1 where it is gone.
        slips: how far each has moved along its two strands, while it was there [mm], shape [crossings, 2].
    """

    unit: LockingUnit | None
    crossings: list[Crossing]
    now: list[int] = field(init=False)
    slips: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.now = list(range(len(self.crossings)))
        self.slips = np.zeros((len(self.crossings), 2))

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        unit = None if self.unit is None else self.unit.state()
        return {"unit": unit, "crossings": stored(self.crossings), "now": self.now, "slips": self.slips}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Tracks:
        """From a checkpoint."""
        unit = None if state["unit"] is None else LockingUnit.restored(state["unit"])
        tracks = cls(unit, restored(state["crossings"]))
        tracks.now, tracks.slips = list(state["now"]), np.array(state["slips"]).reshape(-1, 2)
        return tracks

    def follow(self, follows: Sequence[int], steps: np.ndarray) -> None:
        """Go on to the next state.

        Args:
            follows: which crossing of the next state continues each of the present one, or -1.
            steps: how far each of the present state moves along its strands [mm], shape [crossings, 2].
        """
        for k, number in enumerate(self.now):
            if number >= 0:
                self.now[k] = follows[number]
                self.slips[k] += steps[number]

    @property
    def unit_slip(self) -> UnitSlip | None:
        """Slips of the strands of the locking unit: means over their crossings, weighted by the first normal forces."""
        if self.unit is None:
            return None
        own = [(k, 0 if first else 1) for k, first in self.unit.pairs]
        wrapped = [(k, 1 - side) for k, side in own]
        central = []
        for strand in self.unit.central:
            on = [(k, side) for k, side in wrapped if self._lies_on(strand, k, side)]
            central.append(StrandSlip(strand, self._slip(on)))
        wrapping = self._slip(own)
        return UnitSlip(StrandSlip(self.unit.wrapping, wrapping), tuple(central), self.unit.angle)

    def _lies_on(self, strand: Strand, crossing: int, side: int) -> bool:
        found = self.crossings[crossing]
        return strand.holds(found.rods[side], found.places[side])

    def _slip(self, sides: Sequence[tuple[int, int]]) -> float:
        return _mean([(self.slips[k, side], self.crossings[k].force) for k, side in sides])


class SlipMeter:
    """Follows crossings from one accepted state to the next, and adds up what runs through them.

    A crossing that stays where it is while a rod runs through it moves along the arclength of the rod, whatever the
    knot as a whole does: no frame has to be chosen.

    Args:
        rods: number of rods.
        diameter: of the thinnest rod [mm].

    Attributes:
        through: of each rod, length that has run through its crossings [mm], positive towards its start, shape [rods]:
            means over crossings with strands, or with obstacles where it touches no strand, weighted by normal forces.
        crossings: of the last state.
        since_step: crossings followed since `begin_step`.
        since_mark: the same since `mark`.
    """

    def __init__(self, rods: int, diameter: float) -> None:
        self.diameter = diameter
        self.through = np.zeros(rods)
        self.crossings: list[Crossing] = []
        self.since_step = self.since_mark = Tracks(None, [])

    def update(self, report: ContactReport) -> None:
        """Take an accepted state.

        Args:
            report: its samples in contact.
        """
        now = crossings_of(report, self.diameter)
        follows = matched(self.crossings, now, REACH_OVER_DIAMETER * self.diameter)
        steps = np.zeros((len(self.crossings), 2))
        for i, j in enumerate(follows):
            if j >= 0:
                steps[i] = np.nan_to_num(np.subtract(now[j].places, self.crossings[i].places))
        self.through += _through(self.crossings, follows, steps, self.through.size)
        self.since_step.follow(follows, steps)
        if self.since_mark is not self.since_step:
            self.since_mark.follow(follows, steps)
        self.crossings = now

    def begin_step(self, lines: Sequence[Line]) -> None:
        """A step of the scene begins in the present state; `lines` are its centrelines."""
        self.since_step = self.since_mark = self._tracks(lines)

    def mark(self, lines: Sequence[Line]) -> None:
        """The present state is one of equilibrium; `lines` are its centrelines."""
        self.since_mark = self._tracks(lines)

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        both = {"since_step": self.since_step.state(), "since_mark": self.since_mark.state()}
        return {"through": self.through, "crossings": stored(self.crossings), **both}

    def restore(self, state: dict[str, Any]) -> None:
        """From a checkpoint."""
        self.through, self.crossings = np.array(state["through"]), restored(state["crossings"])
        self.since_step, self.since_mark = (Tracks.restored(state[name]) for name in ("since_step", "since_mark"))

    def _tracks(self, lines: Sequence[Line]) -> Tracks:
        return Tracks(locking_unit(self.crossings, lines, self.diameter), list(self.crossings))


def _through(crossings: Sequence[Crossing], follows: Sequence[int], steps: np.ndarray, rods: int) -> np.ndarray:
    found = np.zeros(rods)
    for rod in range(rods):
        for on_obstacles in (False, True):
            moves = [
                (steps[i, side], crossing.force)
                for i, crossing in enumerate(crossings)
                if follows[i] >= 0 and crossing.on_obstacle == on_obstacles
                for side in (0, 1)
                if crossing.rods[side] == rod
            ]
            if moves:
                found[rod] = _mean(moves)
                break
    return found


def _mean(values: Sequence[tuple[float, float]]) -> float:
    """Mean of values with weights; 0 of nothing."""
    total = sum(weight for _, weight in values)
    return float(sum(value * weight for value, weight in values) / total) if total > 0.0 else 0.0
