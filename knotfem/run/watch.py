"""Watching over the knot: no strand may pass through another, no knot that must hold may come undone."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from knotfem.centerline.closure import linking_number
from knotfem.centerline.diagram import crossing_signature
from knotfem.centerline.frames import tangents
from knotfem.centerline.knot_type import knot_type
from knotfem.centerline.passage import passed_through
from knotfem.errors import KnotLost
from knotfem.run.simulation import Simulation


@dataclass(frozen=True)
class RodKnot:
    """What one rod is tied into.

    Attributes:
        name: of the knot, both ends continued as they left the mapping.
        jones: polynomial in t.
        crossings: signature seen from the front (viewer at -y, x right, z up).
        linking: with each obstacle's axis.
    """

    name: str
    jones: str
    crossings: str
    linking: tuple[int, ...]

    @property
    def undone(self) -> bool:
        """Neither knotted nor hitched."""
        return self.name == "unknot" and not any(self.linking)


class KnotWatch:
    """Names knots and finds passages.

    Args:
        model: rods; the ends of their targets say where the ends are continued to for naming.
    """

    def __init__(self, model: Simulation) -> None:
        self.model = model
        self.ends = []
        for rod in model.rods:
            t = tangents(rod.target.points)
            self.ends.append((-t[0], t[-1]))

    def name(self, x: np.ndarray) -> dict[str, dict]:
        """Knots of all rods by the rod's name, fit for JSON."""
        return {rod.scene.name: asdict(knot) for rod, knot in zip(self.model.rods, self.knots(x), strict=True)}

    def knots(self, x: np.ndarray) -> list[RodKnot]:
        """Knots of all rods at positions [mm], shape [nodes, unknowns]."""
        result = []
        for points, ends in zip(self.model.centrelines(x), self.ends, strict=True):
            kind = knot_type(points, ends)
            linking = tuple(int(linking_number(points, o.point, o.axis)) for o in self.model.scene.obstacles)
            result.append(RodKnot(kind.name, str(kind.jones), crossing_signature(points), linking))
        return result

    def check_passage(self, before: np.ndarray, after: np.ndarray, time: float) -> None:
        """Raise KnotLost where a strand passed through another from one accepted state to the next."""
        found = passed_through(self.model.centrelines(before), self.model.centrelines(after), self.model.diameter)
        if found is None:
            return
        rods = [self.model.rods[i] for i in found.rods]
        places = " and ".join(
            f"s/L = {edge / rod.scene.slices:.3f} of {rod.scene.name}"
            for edge, rod in zip(found.edges, rods, strict=True)
        )
        raise KnotLost(f"strands passed through each other at {time:.6g} s: {places}")
