"""What contact asks of a surface.

Two kinds of surface are known: tubes of hexahedral rods (`knotfem.contact.tube`) and centrelines of discrete rods with
a radius (`knotfem.contact.curve`). Search, pairs, and the loops over them are written once, on the functions below,
which a surface implements for its own view; Numba chooses by the type of the view when it compiles a loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from knotfem.contact.samples import Samples, SampleView
from knotfem.sparse.scatter import MatrixView

SurfaceView = Any
"""`TubeView` or `CurveView`."""


class PairView(NamedTuple):
    """Pairs of a sample and the closest point on a rod.

    Attributes:
        sample: shape [pairs].
        rod: that the sample may touch, the primary one, shape [pairs].
        at: parameters of the closest point, shape [pairs, parameters].
        gap: [mm], infinite where there is no closest point, shape [pairs].
        weight: fraction of the sample's measure that the pair carries, shape [pairs].
        force: normal force [N], shape [pairs].
        slope: its derivative by the overlap [N/mm], shape [pairs].
        stiffness, ramp: of the normal law.
    """

    sample: np.ndarray
    rod: np.ndarray
    at: np.ndarray
    gap: np.ndarray
    weight: np.ndarray
    force: np.ndarray
    slope: np.ndarray
    stiffness: float
    ramp: float


class Query(NamedTuple):
    """Where a closest point is looked for.

    Attributes:
        rod: on which it is to lie.
        station: of the rod, near which it is to lie.
        offset: distance of the point's own surface from it [mm].
        reach: gaps up to it count [mm].
    """

    rod: int
    station: int
    offset: float
    reach: float


class Target(NamedTuple):
    """What pairs add to.

    Attributes:
        residual: shape [nodes, width].
        matrix: tangent, where wanted.
    """

    residual: np.ndarray
    matrix: MatrixView


class Stations(NamedTuple):
    """Stations of all rods: the cross-sections of hexahedral rods, the nodes of discrete ones.

    Attributes:
        node: axis node of each station, rods one behind the other, shape [stations].
        first: first station of each rod, and the number of all, shape [rods + 1].
        spacing: distance of neighbours when free of stress [mm], shape [rods].
        radius: of each rod [mm], shape [rods].
    """

    node: np.ndarray
    first: np.ndarray
    spacing: np.ndarray
    radius: np.ndarray


@dataclass(frozen=True)
class SearchLimits:
    """How pairs are looked for, in radii of the thinnest rod.

    Attributes:
        gap: pairs with a smaller gap are kept.
        stale: the search is repeated when a node has moved so far.
        closing: a predicted move may close no pair by more; one that drives strands into each other costs more Newton
            iterations than it saves.
        neighbour: strands of one rod closer along the arc are not looked at.
    """

    gap: float
    stale: float
    closing: float = 1.0 / 6.0
    neighbour: float = 3.2


class Surface(Protocol):
    """A surface of all rods.

    Attributes:
        view: its arrays, of a type of its own.
        stations: of the rods.
        limits: of the search.
        parameters: number of parameters of a point.
        width: unknowns of a node.
        settled: whether the weight of a pair stays as it is while the pair is in contact.
    """

    view: SurfaceView
    stations: Stations
    limits: SearchLimits
    parameters: int
    width: int
    settled: bool

    def weights(self, x: np.ndarray, samples: Samples, points: np.ndarray, pairs: PairView) -> np.ndarray:
        """Fraction of the sample's measure that each pair carries, shape [pairs]."""
        ...

    def normals(self, x: np.ndarray, points: np.ndarray, pairs: PairView, chosen: np.ndarray) -> np.ndarray:
        """Unit vectors from the surface to the samples of the chosen pairs, which lie at `points`, shape [n, 3]."""
        ...

    def stencils(self, samples: Samples, pairs: PairView, near: np.ndarray) -> Sequence[np.ndarray]:
        """Nodes that the near pairs couple, padded so that contact may slide; arrays of shape [stencils, nodes]."""
        ...


def room_of(surface: SurfaceView) -> Any:
    """Work space of the functions below."""
    raise TypeError(f"no surface: {type(surface).__name__}")


def closest(
    x: np.ndarray, surface: SurfaceView, rod: int, point: np.ndarray, offset: float, at: np.ndarray, room: Any
) -> float:
    """Signed distance of a point's surface from a rod, by Newton from the parameters `at`, which are updated.

    Args:
        x: positions, shape [nodes, width].
        surface: of all rods.
        rod: which one.
        point: shape [3].
        offset: distance of the point's own surface from it [mm].
        at: parameters, shape [parameters].
        room: see `room_of`.

    Returns:
        The gap [mm]; infinite where there is no closest point on the rod or at most one segment beyond its ends.
    """
    raise TypeError(f"no surface: {type(surface).__name__}")


def seek(
    x: np.ndarray, surface: SurfaceView, stations: Stations, query: Query, point: np.ndarray, at: np.ndarray, room: Any
) -> float:
    """The like without parameters to begin with, near a station of the rod; infinite where nothing is within reach."""
    raise TypeError(f"no surface: {type(surface).__name__}")


def add_pair(
    x: np.ndarray, surface: SurfaceView, samples: SampleView, points: np.ndarray, pairs: PairView, k: int,
    target: Target, room: Any,
) -> bool:  # fmt: skip
    """Add the force of one pair to the residual and its tangent to the matrix. False where it lies outside.

    Args:
        x: positions, shape [nodes, width].
        surface: of all rods.
        samples: of all rods.
        points: places of the samples, shape [samples, 3].
        pairs: all pairs, with their normal forces and slopes.
        k: which pair.
        target: residual and matrix.
        room: see `room_of`.
    """
    raise TypeError(f"no surface: {type(surface).__name__}")
