"""From integration points to nodes: L2 projection of fields of one rod, with scikit-fem's mass matrix.

The nodal values v of a field f known at the integration points minimise the integral of (sum_a N_a v_a - f)^2 over the
reference volume:

    sum_b M_ab v_b = int N_a f dV        M_ab = int N_a N_b dV

The mass matrix is consistent, so that a field which the shape functions can represent is met, and the integral of every
field is kept. It never changes and is factorised once. Next to a jump the nodal values overshoot a little, as those of
any such projection do; the means over the hexahedra do not.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from knotfem.mesh.quality import to_skfem
from knotfem.mesh.reference import hexahedron
from knotfem.mesh.rod import RodMesh
from knotfem.models.solid.formulation import Formulation

if TYPE_CHECKING:
    from scipy.sparse import csc_array


class Projection:
    """Projects fields of a rod onto its nodes.

    Args:
        mesh: the rod.
        formulation: tables of a layer of its hexahedra of mean length.
    """

    def __init__(self, mesh: RodMesh, formulation: Formulation) -> None:
        from scipy.sparse.linalg import splu

        self._layers, self._nodes = mesh.layers, len(mesh.nodes)
        self._heights = mesh.heights[:, None, None, None]
        self._parts = np.einsum("qg,ga->qga", formulation.weights, formulation.shapes)
        self._mass = splu(_mass(mesh), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def nodal(self, values: np.ndarray) -> np.ndarray:
        """Values at the nodes, shape [nodes, components].

        Args:
            values: at the integration points, shape [slices, quads, points, components].
        """
        loads = self._heights * np.einsum("sqgc,qga->sqac", values, self._parts, optimize=True)
        right = np.zeros((self._nodes, values.shape[-1]))
        np.add.at(right, self._layers, loads)
        return self._mass.solve(right)


def _mass(mesh: RodMesh) -> csc_array:
    """Mass matrix of unit density in the numbering of the rod, shape [nodes, nodes]."""
    from scipy.sparse import csc_array
    from skfem import CellBasis, ElementHex1, ElementHex2, MeshHex2
    from skfem.models.poisson import mass

    hexes = to_skfem(mesh, corners_only=True)
    if mesh.span == 1:
        basis = CellBasis(hexes, ElementHex1(), intorder=2)
    else:
        straight = MeshHex2.from_mesh(hexes)
        number = _numbers(straight.dofs.element_dofs, mesh)
        basis = CellBasis(
            replace(straight, doflocs=np.ascontiguousarray(mesh.nodes[number].T)), ElementHex2(), intorder=4
        )
    number = _numbers(basis.element_dofs, mesh)
    matrix = mass.assemble(basis).tocoo()
    return csc_array((matrix.data, (number[matrix.row], number[matrix.col])), shape=(len(mesh.nodes),) * 2)


def _numbers(dofs: np.ndarray, mesh: RodMesh) -> np.ndarray:
    """The rod's number of each unknown of scikit-fem, shape [nodes]; dofs: of each hexahedron, shape [n, hexes]."""
    number = np.empty(len(mesh.nodes), dtype=np.int64)
    number[dofs[hexahedron(mesh.span).order].T] = mesh.hexes
    return number
