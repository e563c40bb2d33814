"""Watching over the knot: no strand may pass through another, no knot that must hold may come undone."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np

from knotfem.errors import KnotLost
from knotfem.geometry.frames import tangents
from knotfem.models.base import Model
from knotfem.run.knot_words import Knots
from knotfem.topology.closures import closures_of, is_knotted, ways_of
from knotfem.topology.diagram import crossing_signature
from knotfem.topology.interpenetration import first_interpenetration
from knotfem.topology.linking import link_type, linking_number, winding_range
from knotfem.topology.words import come_undone

FEWEST_TURNS = 0.75
"""Turns about an obstacle that make a hitch of a rod which is not linked with it, as a cow hitch is not. A rod that
only passes turns by less than half a turn."""
LEAST_UNWINDING = 0.25
"""Turns that a hitch must have lost, at the least, to have left its obstacle: one of half a turn is linked or not as
its ends swing."""


@dataclass(frozen=True)
class RodKnot:
    """What one rod is tied into.

    Attributes:
        name: of the knot by most ways of continuing the ends.
        said: the name, with how many closures are of it where they disagree; of a hitch, its obstacle and its turns.
        closures: number of closures by the name of the knot.
        jones: polynomial in t, of the knot of most closures.
        crossings: signature seen from the front (viewer at -y, x right, z up).
        linking: with each obstacle's axis.
        turns: about each obstacle.
        laced: by the name of each other rod, for each way of continuing the ends, the Jones polynomial of the link with
            it; empty where the two are not linked.
    """

    name: str
    said: str
    closures: dict[str, int]
    jones: str
    crossings: str
    linking: tuple[int, ...]
    turns: tuple[float, ...]
    laced: dict[str, tuple[str, ...]]


class KnotMonitor:
    """Names knots and finds strands that pass through each other.

    An open rod is closed in several ways: along its tangents, away from the middle of all rods, and along a number of
    random directions, all as they were when it was tied. An end may lie so that its continuation in one direction runs
    through a loop; no way decides alone. Rods are linked or apart where the first two ways agree.

    Args:
        model: rods.
        centrelines: of the tied rods, whose ends are continued [mm], shape [n, 3] each; None for those of the scene.

    Attributes:
        ends: of each rod, along its tangents.
        outward: of each rod, away from the middle of all.
    """

    def __init__(self, model: Model, centrelines: Sequence[np.ndarray] | None = None) -> None:
        self.model = model
        tied = [target.points for target in model.targets] if centrelines is None else centrelines
        every = np.concatenate(tied)
        middle = 0.5 * (every.min(axis=0) + every.max(axis=0))
        self.ends, self.outward = [], []
        for points in tied:
            t = tangents(points)
            self.ends.append((-t[0], t[-1]))
            self.outward.append((points[0] - middle, points[-1] - middle))

    def knots(self, x: np.ndarray) -> Knots:
        """Knots of all rods at positions [mm], shape [nodes, width]."""
        return self.knots_along(self.model.centrelines(x))

    def knots_along(self, lines: Sequence[np.ndarray]) -> Knots:
        """Knots of all rods whose centrelines lie along these [mm], shape [n, 3] each."""
        rods, laced = [rod.name for rod in self.model.rods], self._laced(lines)
        result = {}
        for number, (rod, points) in enumerate(zip(rods, lines, strict=True)):
            closures = closures_of(points, self._ways(number))
            linking, turns = self._linking(points), self._turns(points)
            name, said = closures.most.name, str(closures)
            if said == "unknot":
                said = self._hitch(linking, turns) or said
            knot = RodKnot(
                name,
                said,
                closures.counts,
                str(closures.most.jones),
                crossing_signature(points),
                linking,
                turns,
                laced[rod],
            )
            result[rod] = asdict(knot)
        return result

    def lost(self, before: Knots, x: np.ndarray) -> str:
        """What no longer holds, in words; empty where each rod is still knotted or hitched, and all linked rods are.

        Args:
            before: knots that the steps set out from.
            x: positions [mm], shape [nodes, width].
        """
        for rod, points in enumerate(self.model.centrelines(x)):
            name = self.model.rods[rod].name
            tied, hitched_to = before[name], self._hitched_to(before[name])
            knotted = tied["name"] != "unknot"
            if not (knotted or hitched_to) or (knotted and is_knotted(points, self._ways(rod))):
                continue
            if all(self._left(tied, obstacle, points) for obstacle in hitched_to):
                what = tied["name"] if knotted else "hitch"
                gone = "" if knotted else f": it has left {' and '.join(hitched_to)}"
                return f"{come_undone(what, name)}{gone}"
        return self._apart(before, x)

    def gone(self, before: Knots, x: np.ndarray, told: Container[str] = ()) -> list[str]:
        """All that is no longer as it was, each in words: knots undone, obstacles left, rods apart; see `lost`.

        Args:
            before: knots that the steps set out from.
            x: positions [mm], shape [nodes, width].
            told: what need not be looked at again.
        """
        found = []
        for rod, points in enumerate(self.model.centrelines(x)):
            name = self.model.rods[rod].name
            tied = before[name]
            undone = come_undone(tied["name"], name)
            if tied["name"] != "unknot" and undone not in told and not is_knotted(points, self._ways(rod)):
                found.append(undone)
            found += [f"{name} has left {o}" for o in self._hitched_to(tied) if self._left(tied, o, points)]
        found.append(self._apart(before, x))
        return [said for said in found if said and said not in told]

    def _ways(self, rod: int) -> list[tuple[Any, Any]]:
        return ways_of(self.ends[rod], self.outward[rod])

    def _laced(self, lines: Sequence[np.ndarray]) -> dict[str, dict[str, tuple[str, ...]]]:
        rods = [rod.name for rod in self.model.rods]
        linked: dict[str, dict[str, tuple[str, ...]]] = {rod: {} for rod in rods}
        for i, j in combinations(range(len(rods)), 2):
            ways = ((self.ends[i], self.ends[j]), (self.outward[i], self.outward[j]))
            links = [link_type((lines[i], lines[j]), ends) for ends in ways]
            found = tuple(str(link.jones) if link.linked else "" for link in links)
            linked[rods[i]][rods[j]] = linked[rods[j]][rods[i]] = found
        return linked

    def _apart(self, before: Knots, x: np.ndarray) -> str:
        """Which two rods that were linked, each way of continuing the ends, are so in none; "" for no rods."""
        if not any(all(links) for tied in before.values() for links in tied["laced"].values()):
            return ""
        laced = self._laced(self.model.centrelines(x))
        for rod, tied in before.items():
            for other, links in tied["laced"].items():
                if apart(links, laced[rod][other]):
                    return f"{rod} and {other} have come apart"
        return ""

    def _linking(self, points: np.ndarray) -> tuple[int, ...]:
        return tuple(int(linking_number(points, o.point, o.axis)) for o in self.model.scene.obstacles)

    def _turns(self, points: np.ndarray) -> tuple[float, ...]:
        obstacles = self.model.scene.obstacles
        return tuple(round(winding_range(points, o.point, o.axis) / (2.0 * math.pi), 3) for o in obstacles)

    def _hitched_to(self, knot: Mapping[str, Any]) -> list[str]:
        """Names of the obstacles that a rod is tied round."""
        both = zip(self.model.scene.obstacles, knot["linking"], knot["turns"], strict=True)
        return [obstacle.name for obstacle, linking, turns in both if hitched(linking, turns)]

    def _left(self, tied: Mapping[str, Any], obstacle: str, points: np.ndarray) -> bool:
        """Whether a rod is no longer tied round an obstacle."""
        i = [o.name for o in self.model.scene.obstacles].index(obstacle)
        turns = self._turns(points)[i]
        return not hitched(self._linking(points)[i], turns) and tied["turns"][i] - turns >= LEAST_UNWINDING

    def _hitch(self, linking: Sequence[int], turns: Sequence[float]) -> str:
        """Name of a hitch; "" of a rod that is none."""
        both = zip(self.model.scene.obstacles, linking, turns, strict=True)
        found = [f"{o.name} ({wound:.1f} turns)" for o, link, wound in both if hitched(link, wound)]
        return f"hitch round {' and '.join(found)}" if found else ""

    def check_interpenetration(self, before: np.ndarray, after: np.ndarray, time: float) -> None:
        """Raise KnotLost where a strand passed through another from one accepted state to the next."""
        lines = self.model.centrelines
        found = first_interpenetration(lines(before), lines(after), self.model.diameter)
        if found is None:
            return
        places = " and ".join(
            f"s/L = {self._fraction(rod, edge):.3f} of {self.model.rods[rod].name}"
            for edge, rod in zip(found.edges, found.rods, strict=True)
        )
        raise KnotLost(f"strands passed through each other at {time:.6g} s: {places}")

    def _fraction(self, rod: int, edge: float) -> float:
        """Arclength over the length of a rod, of a place counted in edges."""
        fractions = self.model.targets[rod].slices.fractions
        return float(np.interp(edge, np.arange(fractions.size), fractions))


def of_checkpoint(knots: Knots | None) -> Knots | None:
    """Knots as a checkpoint has them; those of older versions lack the turns about obstacles and the sentence."""
    if knots is None:
        return None
    return {
        rod: {"said": knot["name"], "turns": tuple(float(abs(number)) for number in knot["linking"]), **knot}
        for rod, knot in knots.items()
    }


def hitched(linking: int, turns: float) -> bool:
    """Whether a rod is tied round an obstacle.

    Args:
        linking: number with the obstacle's axis.
        turns: about it.
    """
    return linking != 0 or turns >= FEWEST_TURNS


def apart(before: Sequence[str], now: Sequence[str]) -> bool:
    """Whether two rods that were linked have come apart: linked each way of continuing the ends, then in none.

    Args:
        before: Jones polynomials of their links, "" where they are not linked.
        now: likewise.
    """
    return all(before) and not any(now)
