"""The locking unit: which strand wraps others, and which strands it wraps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from knotfem.geometry.vectors import unit
from knotfem.stability.crossings import Crossing

WINDOW_OVER_DIAMETER = 1.5
"""Curvature at a crossing is the mean over so long a part of the strand to either side of it."""
LEAST_WRAP = 0.75 * math.pi
"""A strand that turns by less between its first and its last crossing wraps nothing."""
LONGEST_LOOP = 3.0
"""A rod meets itself after a loop where the loop is at most so many times as long as what wraps others in it."""


@dataclass(frozen=True, eq=False)
class Line:
    """Centreline of a rod.

    Attributes:
        points: vertices [mm], shape [n, 3].
        arclengths: of them, without strain [mm], shape [n].
    """

    points: np.ndarray
    arclengths: np.ndarray

    def at(self, arclength: float) -> np.ndarray:
        """A point [mm], shape [3]."""
        return np.array([np.interp(arclength, self.arclengths, self.points[:, i]) for i in range(3)])

    def tangent(self, arclength: float) -> np.ndarray:
        """Unit tangent, shape [3]."""
        edge = int(np.clip(np.searchsorted(self.arclengths, arclength) - 1, 0, len(self.points) - 2))
        return unit(self.points[edge + 1] - self.points[edge])

    def foot(self, point: np.ndarray, near: float, reach: float) -> float:
        """Arclength of the point of the line that is closest to another point, within a reach of an arclength [mm].

        Args:
            point: shape [3].
            near: arclength [mm].
            reach: to either side [mm].
        """
        first, last = np.searchsorted(self.arclengths, (near - reach, near + reach))
        first, last = max(int(first) - 1, 0), min(int(last), len(self.points) - 1)
        start, edge = self.points[first:last], np.diff(self.points[first : last + 1], axis=0)
        along = np.clip(((point - start) * edge).sum(axis=1) / (edge**2).sum(axis=1), 0.0, 1.0)
        distance = ((start + along[:, None] * edge - point) ** 2).sum(axis=1)
        best = int(distance.argmin())
        s = self.arclengths[first : last + 1]
        return float(s[best] + along[best] * (s[best + 1] - s[best]))

    def turning(self, first: float, last: float) -> float:
        """Angle by which the tangent turns between two arclengths [rad]: the integral of the curvature."""
        inside = (self.arclengths > first) & (self.arclengths < last)
        points = np.vstack([self.at(first), self.points[inside], self.at(last)])
        edges = np.diff(points, axis=0)
        lengths = np.linalg.norm(edges, axis=1)
        t = edges[lengths > 1e-9] / lengths[lengths > 1e-9, None]
        return float(np.arccos(np.clip((t[1:] * t[:-1]).sum(axis=1), -1.0, 1.0)).sum())

    def bending(self, arclength: float, towards: np.ndarray, window: float) -> float:
        """Component of the mean curvature near an arclength along a unit vector [1/mm].

        Args:
            arclength: [mm].
            towards: shape [3].
            window: to either side [mm].
        """
        low, high = max(arclength - window, self.arclengths[0]), min(arclength + window, self.arclengths[-1])
        return float((self.tangent(high) - self.tangent(low)) @ towards) / (high - low)


@dataclass(frozen=True)
class Strand:
    """A part of a rod.

    Attributes:
        rod: which one.
        first, last: arclengths of its ends [mm].
    """

    rod: int
    first: float
    last: float

    def holds(self, rod: int, place: float) -> bool:
        """Whether an arclength [mm] of a rod lies on it."""
        return rod == self.rod and self.first - 1e-9 <= place <= self.last + 1e-9


@dataclass(frozen=True)
class LockingUnit:
    """A strand that wraps others, and those.

    Attributes:
        wrapping: from the first to the last of its crossings with what it wraps.
        angle: by which it turns between them [rad].
        central: strands that it wraps, in the order of the rods and of arclength; empty where it wraps an obstacle.
        pairs: numbers of the crossings between the wrapping strand and what it wraps, and for each whether the wrapping
            strand is its first one.
    """

    wrapping: Strand
    angle: float
    central: tuple[Strand, ...]
    pairs: tuple[tuple[int, bool], ...]

    def state(self) -> dict[str, Any]:
        """For a checkpoint."""
        central = [dict(vars(strand)) for strand in self.central]
        return {**vars(self), "wrapping": dict(vars(self.wrapping)), "central": central}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> LockingUnit:
        """From a checkpoint."""
        central = tuple(Strand(**strand) for strand in state["central"])
        pairs = tuple((int(number), bool(first)) for number, first in state["pairs"])
        return cls(Strand(**state["wrapping"]), float(state["angle"]), central, pairs)


@dataclass(frozen=True)
class _Role:
    """What a strand does at a crossing."""

    crossing: int
    rod: int
    place: float
    half_extent: float
    wraps: bool
    first: bool


def locking_unit(crossings: Sequence[Crossing], lines: Sequence[Line], diameter: float) -> LockingUnit | None:
    """The locking unit of a state, or None where no strand wraps another by `LEAST_WRAP`.

    At each crossing that strand wraps the other which is bent towards it more. Neighbouring crossings along a rod at
    which it wraps belong to one wrapping strand, as long as it is not itself wrapped between them. That of the largest
    angle between its first and its last crossing is the wrapping strand of the unit; what it touches is the central
    one, or several. Where no strand wraps a strand, one that wraps an obstacle is taken. Crossings of a loop with
    itself, between whose two ends the rod only wraps, say nothing.

    Args:
        crossings: of the state.
        lines: centrelines of the rods.
        diameter: of the thinnest rod [mm].
    """
    roles = _roles(crossings, lines, WINDOW_OVER_DIAMETER * diameter)
    for on_obstacle in (False, True):
        best = max(_wrapping(crossings, roles, lines, on_obstacle), key=lambda found: found[1], default=None)
        if best is not None and best[1] >= LEAST_WRAP:
            return _unit(crossings, *best)
    return None


def _roles(crossings: Sequence[Crossing], lines: Sequence[Line], window: float) -> list[_Role]:
    """Roles along the rods, in the order of arclength."""
    roles: list[_Role] = []
    for number, crossing in enumerate(crossings):
        (a, b), (s, other) = crossing.rods, crossing.places
        if crossing.on_obstacle:
            roles.append(_Role(number, a, s, 0.5 * crossing.extents[0], True, True))
            continue
        towards = unit(lines[b].at(other) - lines[a].at(s))
        wraps = lines[a].bending(s, towards, window) >= lines[b].bending(other, -towards, window)
        for first, rod, place, extent in ((True, a, s, crossing.extents[0]), (False, b, other, crossing.extents[1])):
            roles.append(_Role(number, rod, place, 0.5 * extent, wraps == first, first))
    roles.sort(key=lambda role: (role.rod, role.place))
    return [role for role in roles if not _closes_loop(crossings[role.crossing], role.crossing, roles, window)]


def _closes_loop(crossing: Crossing, number: int, roles: Sequence[_Role], margin: float) -> bool:
    """Whether a rod meets itself after a loop that, but for its ends, only wraps others."""
    if crossing.rods[0] != crossing.rods[1]:
        return False
    low, high = crossing.places[0] + margin, crossing.places[1] - margin
    between = [r for r in roles if r.rod == crossing.rods[0] and low <= r.place <= high and r.crossing != number]
    if len(between) < 2 or not all(role.wraps for role in between):
        return False
    return crossing.places[1] - crossing.places[0] <= LONGEST_LOOP * (between[-1].place - between[0].place)


def _wrapping(
    crossings: Sequence[Crossing], roles: Sequence[_Role], lines: Sequence[Line], on_obstacle: bool
) -> list[tuple[list[_Role], float]]:
    """Candidates for the wrapping strand, each with the angle by which it turns."""
    runs: list[list[_Role]] = []
    last: _Role | None = None
    for role in roles:
        if role.wraps and crossings[role.crossing].on_obstacle == on_obstacle:
            if last is not None and last.wraps and last.rod == role.rod and runs and runs[-1][-1] is last:
                runs[-1].append(role)
            else:
                runs.append([role])
        last = role
    return [(run, lines[run[0].rod].turning(*_ends(run))) for run in runs]


def _ends(run: Sequence[_Role]) -> tuple[float, float]:
    return (
        min(role.place - role.half_extent for role in run),
        max(role.place + role.half_extent for role in run),
    )


def _unit(crossings: Sequence[Crossing], run: Sequence[_Role], angle: float) -> LockingUnit:
    wrapping = Strand(run[0].rod, *_ends(run))
    touched: list[tuple[int, float]] = []
    for role in run:
        crossing = crossings[role.crossing]
        if not crossing.on_obstacle:
            other = 1 if role.first else 0
            touched.append((crossing.rods[other], crossing.places[other]))
    pairs = tuple((role.crossing, role.first) for role in run)
    return LockingUnit(wrapping, angle, tuple(_strands(touched, wrapping)), pairs)


def _strands(touched: Sequence[tuple[int, float]], wrapping: Strand) -> list[Strand]:
    """Places on rods joined to strands: neighbours that are nearer than the wrapping strand is long."""
    found: list[Strand] = []
    reach = 0.5 * (wrapping.last - wrapping.first)
    for rod, place in sorted(touched):
        if found and found[-1].rod == rod and place - found[-1].last <= reach:
            found[-1] = Strand(rod, found[-1].first, place)
        else:
            found.append(Strand(rod, place, place))
    return found
