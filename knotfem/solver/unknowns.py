"""The unknowns of a system."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Blocks of unknowns, one for each node; the first three are its place.

    Attributes:
        nodes: number of nodes.
        width: unknowns of a node.
        fixed: those that keep their values whatever is prescribed, boolean, shape [nodes, width]; None for none.
        damping_weights: weight of each node in the Levenberg-Marquardt damping, shape [nodes], summing to one; None for
            equal ones.
        unsymmetric: whether the matrix is stored whole though all terms are symmetric.
    """

    nodes: int
    width: int = 3
    fixed: np.ndarray | None = None
    damping_weights: np.ndarray | None = None
    unsymmetric: bool = False
