"""Viscous drag of a fluid on discrete rods: `knotfem.terms.viscous` on their nodes."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel
from knotfem.mesh.rod_layout import RodLayout
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import add_block
from knotfem.terms.viscous import Settings, ViscousDrag


@kernel
def _add(nodes, blocks, node_ptr, node_adj, data):
    wide = np.zeros((4, 4))
    for k in range(nodes.size):
        wide[:3, :3] = blocks[k]
        if not add_block(nodes[k], nodes[k], wide, 0, 0, node_ptr, node_adj, data):
            return False
    return True


class RodViscousDrag(ViscousDrag):
    """The same on nodes of four unknowns; spin is free."""

    def _add(self, blocks: np.ndarray, matrix: Matrix) -> bool:
        return _add(self.nodes, blocks, matrix.pattern.node_ptr, matrix.pattern.node_adj, matrix.data)


def make(settings: Settings, layout: RodLayout) -> RodViscousDrag:
    """The drag on all rods."""
    edges = np.stack([layout.edges, layout.edges + 1], axis=1)
    lengths = layout.spacing[layout.rod[layout.edges]]
    return RodViscousDrag(edges, lengths, settings.normal, settings.tangential)
