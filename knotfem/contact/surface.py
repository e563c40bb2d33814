"""What contact asks of a surface.

Two kinds of surface are known: tubes of hexahedral rods (`knotfem.contact.tube`) and centrelines of discrete rods with
a radius (`knotfem.contact.curve`). Search and pairs are written once. A surface finds closest points (`Surface`) and
adds the force of a pair (`add_pair`), for which Numba chooses by the type of the view when it compiles the loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from knotfem.contact.law import Penalty
from knotfem.contact.samples import Samples, SampleView
from knotfem.contact.stations import Stations
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
        law: normal law.
    """

    sample: np.ndarray
    rod: np.ndarray
    at: np.ndarray
    gap: np.ndarray
    weight: np.ndarray
    force: np.ndarray
    slope: np.ndarray
    law: Penalty


class Target(NamedTuple):
    """What pairs add to.

    Attributes:
        residual: shape [nodes, width].
        matrix: tangent, where wanted.
    """

    residual: np.ndarray
    matrix: MatrixView


@dataclass(frozen=True)
class SearchLimits:
    """How pairs are looked for, in radii of the thinnest rod.

    Attributes:
        gap: pairs with a smaller gap are kept.
        stale: the search is repeated when a node has moved so far.
        coupled: pairs are in the sparsity from so far before they touch. A pair that closes further in one step costs
            an analysis, one that never touches makes each factorisation dearer.
        closing: a predicted move may close no pair by more; one that drives strands into each other costs more Newton
            iterations than it saves.
        neighbour: strands of one rod closer along the arc are not looked at.
    """

    gap: float
    stale: float
    coupled: float
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
    """

    view: SurfaceView
    stations: Stations
    limits: SearchLimits
    parameters: int
    width: int

    def project(self, x: np.ndarray, samples: SampleView, points: np.ndarray, pairs: PairView) -> None:
        """Closest points and gaps of pairs at positions x, from where they were, into `pairs`.

        The gap is infinite where there is no closest point on the rod or at most one segment beyond its ends.
        """
        ...

    def seek(
        self, x: np.ndarray, samples: SampleView, points: np.ndarray, sought: np.ndarray, reach: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Closest points that are not known before.

        Args:
            x: positions, shape [nodes, width].
            samples: of all rods.
            points: places of the samples, shape [samples, 3].
            sought: sample, rod, and station of the rod near which the closest point is to lie, shape [n, 3].
            reach: gaps up to it count [mm].

        Returns:
            Gaps [mm], shape [n], infinite where nothing is within reach, and parameters, shape [n, parameters].
        """
        ...

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
