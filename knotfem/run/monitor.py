"""Watching over the knot: no strand may pass through another, no knot that must hold may come undone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np

from knotfem.errors import KnotLost
from knotfem.geometry.frames import tangents
from knotfem.models.base import Model
from knotfem.topology.diagram import crossing_signature
from knotfem.topology.interpenetration import first_interpenetration
from knotfem.topology.knot_type import knot_type
from knotfem.topology.linking import link_type, linking_number


@dataclass(frozen=True)
class RodKnot:
    """What one rod is tied into.

    Attributes:
        name: of the knot, both ends continued as they left the mapping.
        jones: polynomial in t.
        crossings: signature seen from the front (viewer at -y, x right, z up).
        linking: with each obstacle's axis.
        laced: by the name of each other rod, for each way of continuing the ends, the Jones polynomial of the link with
            it; empty where the two are not linked.
    """

    name: str
    jones: str
    crossings: str
    linking: tuple[int, ...]
    laced: dict[str, tuple[str, ...]]


Knots = dict[str, dict[str, Any]]
"""Fields of `RodKnot` of each rod, by its name, fit for JSON."""


class KnotMonitor:
    """Names knots and finds strands that pass through each other.

    Args:
        model: rods.
        centrelines: of the tied rods, whose ends are continued [mm], shape [n, 3] each; None for those of the scene.

    Attributes:
        ends: of each rod, along its tangents: so knots are named.
        outward: of each rod, away from the middle of all. Rods are linked or apart where both ways agree: an end may
            lie so that its continuation one way runs through the other rod.
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
        rods, lines = [rod.name for rod in self.model.rods], self.model.centrelines(x)
        linked: dict[str, dict[str, tuple[str, ...]]] = {rod: {} for rod in rods}
        for i, j in combinations(range(len(rods)), 2):
            ways = ((self.ends[i], self.ends[j]), (self.outward[i], self.outward[j]))
            links = [link_type((lines[i], lines[j]), ends) for ends in ways]
            found = tuple(str(link.jones) if link.linked else "" for link in links)
            linked[rods[i]][rods[j]] = linked[rods[j]][rods[i]] = found
        result = {}
        for rod, points, ends in zip(rods, lines, self.ends, strict=True):
            kind = knot_type(points, ends)
            linking = tuple(int(linking_number(points, o.point, o.axis)) for o in self.model.scene.obstacles)
            knot = RodKnot(kind.name, str(kind.jones), crossing_signature(points), linking, linked[rod])
            result[rod] = asdict(knot)
        return result

    @staticmethod
    def lost(before: Knots, now: Knots) -> str:
        """What has come undone, in words; empty where all that was knotted or linked still is."""
        for rod, tied in before.items():
            knot = now[rod]
            if _holds(tied) and not _holds(knot):
                return f"the {'hitch' if tied['name'] == 'unknot' else tied['name']} of {rod} has come undone"
            for other, links in tied["laced"].items():
                if all(links) and not any(knot["laced"][other]):
                    return f"{rod} and {other} have come apart"
        return ""

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


def _holds(knot: dict[str, Any]) -> bool:
    """Whether a rod is knotted in itself or hitched to an obstacle."""
    return knot["name"] != "unknot" or any(knot["linking"])
