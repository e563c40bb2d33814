"""Quality of a rod of hexahedra, measured with scikit-fem's trilinear map and quadrature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from knotfem.errors import InputError
from knotfem.mesh.reference import hexahedron
from knotfem.mesh.rod import RodMesh

if TYPE_CHECKING:
    from skfem import MeshHex

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class QualityReport:
    """Quality of the hexahedra, in mm.

    Attributes:
        hexes: number of hexahedra.
        min_scaled_jacobian: smallest corner determinant over the product of its three edges: 1 for a brick, below 0 for
            an inverted corner.
        max_aspect_ratio: largest ratio of longest to shortest edge in one hexahedron.
        smallest_edge: shortest edge in mm.
        volume: volume in mm^3.
        volume_ratio: volume over that of the circular cylinder pi r^2 L.
        min_volume_ratio: smallest element volume over the mean.
    """

    hexes: int
    min_scaled_jacobian: float
    max_aspect_ratio: float
    smallest_edge: float
    volume: float
    volume_ratio: float
    min_volume_ratio: float


def to_skfem(mesh: RodMesh, nodes: FloatArray | None = None, *, corners_only: bool = False) -> MeshHex:
    """The rod as a scikit-fem mesh, whose hexahedra number their corners in another order than VTK.

    Args:
        mesh: the rod.
        nodes: positions in mm other than the reference, shape (N, 3).
        corners_only: take quadratic hexahedra by their corners alone, numbered anew, and not as eight bricks each.
    """
    from skfem import MeshHex

    places, cells = mesh.nodes if nodes is None else nodes, mesh.bricks
    if corners_only and mesh.span == 2:
        used, cells = np.unique(mesh.cells[:, :8], return_inverse=True)
        places, cells = places[used], cells.reshape(-1, 8)
    return MeshHex(
        np.ascontiguousarray(places.T),
        np.ascontiguousarray(cells[:, np.argsort(hexahedron(1).order)].T),
        sort_t=False,
        validate=False,
    )


def report(mesh: RodMesh, nodes: FloatArray | None = None) -> QualityReport:
    """Measure the hexahedra of a rod, quadratic ones as the eight bricks of their nodes.

    Args:
        mesh: the rod.
        nodes: deformed positions in mm, shape (N, 3); the reference if left out.

    Raises:
        InputError: the positions are not finite or do not fit the mesh.
    """
    from skfem import CellBasis, ElementHex1

    if nodes is not None and nodes.shape != mesh.nodes.shape:
        raise InputError("positions do not fit the mesh", found=nodes.shape, expected=f"shape {mesh.nodes.shape}")
    if nodes is not None and not np.isfinite(nodes).all():
        raise InputError("positions are not finite")
    hexes = to_skfem(mesh, nodes)
    gradient = np.moveaxis(hexes.mapping().DF(0.5 * (hexahedron(1).nodes.T + 1.0)), (0, 1), (-2, -1))
    edges = np.linalg.norm(gradient, axis=-2)
    scaled = np.linalg.det(gradient) / edges.prod(axis=-1)
    longest, shortest = edges.max(axis=(1, 2)), edges.min(axis=(1, 2))
    basis = CellBasis(hexes, ElementHex1(), intorder=2)
    volumes = np.sum(np.sign(basis.mapping.detDF(basis.X)) * basis.dx, axis=1)
    volume = float(volumes.sum())
    return QualityReport(
        hexes=len(mesh.hexes),
        min_scaled_jacobian=float(scaled.min()),
        max_aspect_ratio=float((longest / shortest).max()),
        smallest_edge=float(shortest.min()),
        volume=volume,
        volume_ratio=volume / (np.pi * mesh.radius**2 * mesh.length),
        min_volume_ratio=float(volumes.min() / volumes.mean()),
    )
