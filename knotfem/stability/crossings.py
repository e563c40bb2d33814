"""Crossings: places where two strands, or a strand and an obstacle, press on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from knotfem.contact.report import ContactReport

JOIN_OVER_DIAMETER = 0.6
"""Samples in contact whose arclengths on both strands differ by less belong to one crossing."""


@dataclass(frozen=True)
class Crossing:
    """Two strands in contact; on an obstacle, one strand and the obstacle.

    Attributes:
        rods: of the two strands, the one nearer to the start of the first rod being first; -1 - c for obstacle c.
        places: arclength of the centre of contact on each strand [mm], nan on an obstacle.
        extents: length of each strand in contact [mm], 0 on an obstacle.
        force: sum of normal forces [N].
        sliding: fraction of this sum that is carried by samples that slide.
    """

    rods: tuple[int, int]
    places: tuple[float, float]
    extents: tuple[float, float]
    force: float
    sliding: float

    @property
    def on_obstacle(self) -> bool:
        """Whether a strand presses on an obstacle."""
        return self.rods[1] < 0


def crossings_of(report: ContactReport, diameter: float) -> list[Crossing]:
    """Crossings of a state, ordered by the arclength of their first strand.

    Args:
        report: samples in contact.
        diameter: of the thinnest rod [mm].
    """
    if report.rod.size == 0:
        return []
    rods = np.stack([report.rod, report.other], axis=1)
    places = np.stack([report.arclength, report.other_arclength], axis=1)
    later = (rods[:, 1] == rods[:, 0]) & (places[:, 1] < places[:, 0])
    swapped = (rods[:, 1] >= 0) & ((rods[:, 1] < rods[:, 0]) | later)
    rods[swapped], places[swapped] = rods[swapped, ::-1], places[swapped, ::-1]
    found: list[Crossing] = []
    for pair in np.unique(rods, axis=0):
        on = np.flatnonzero((rods == pair).all(axis=1))
        for members in _clusters(np.nan_to_num(places[on]), JOIN_OVER_DIAMETER * diameter):
            found.append(_crossing(report, on[members], places, pair))
    return sorted(found, key=lambda crossing: (crossing.rods[0], crossing.places[0]))


def matched(before: Sequence[Crossing], now: Sequence[Crossing], reach: float) -> list[int]:
    """Which crossing of a later state continues each of an earlier one; -1 for those that are gone.

    Args:
        before: of the earlier state.
        now: of the later one.
        reach: how far the places of a crossing may have moved [mm].
    """
    found, free = [-1] * len(before), set(range(len(now)))
    distances = sorted(
        (distance, i, j)
        for i, old in enumerate(before)
        for j, new in enumerate(now)
        if old.rods == new.rods and (distance := _distance(old, new)) <= reach
    )
    for _, i, j in distances:
        if found[i] < 0 and j in free:
            found[i] = j
            free.remove(j)
    return found


def stored(crossings: Sequence[Crossing]) -> list[dict[str, Any]]:
    """For a checkpoint."""
    return [dict(vars(crossing)) for crossing in crossings]


def restored(values: Sequence[dict[str, Any]]) -> list[Crossing]:
    """From a checkpoint."""
    pairs = ("rods", "places", "extents")
    return [Crossing(**{**value, **{name: tuple(value[name]) for name in pairs}}) for value in values]


def _clusters(points: np.ndarray, reach: float) -> list[np.ndarray]:
    pairs = KDTree(points).query_pairs(reach, p=np.inf, output_type="ndarray")
    graph = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, label = connected_components(graph, directed=False)
    return [np.flatnonzero(label == k) for k in range(count)]


def _crossing(report: ContactReport, on: np.ndarray, places: np.ndarray, pair: np.ndarray) -> Crossing:
    weights, at = report.normal_force[on], places[on]
    total = float(weights.sum())
    first, second = (float(value) for value in weights @ at / total)
    extents = np.ptp(at, axis=0)
    return Crossing(
        rods=(int(pair[0]), int(pair[1])),
        places=(first, second),
        extents=(float(extents[0]), 0.0 if pair[1] < 0 else float(extents[1])),
        force=total,
        sliding=float(weights[report.slides[on]].sum()) / total,
    )


def _distance(old: Crossing, new: Crossing) -> float:
    along = abs(old.places[0] - new.places[0])
    return along if old.on_obstacle else max(along, abs(old.places[1] - new.places[1]))
