"""Forces on points, spread over the nodes by which the points move."""

from __future__ import annotations

import numpy as np

from knotfem.compiled import kernel


@kernel(inline="always")
def spread_force(
    residual: np.ndarray, nodes: np.ndarray, weights: np.ndarray, size: float, direction: np.ndarray
) -> None:
    """Add a force to the residual, on a point that is a sum of places of nodes.

    Args:
        residual: shape [nodes, width].
        nodes: shape [n].
        weights: theirs in the place of the point, shape [n].
        size: of the force.
        direction: of the force, shape [3].
    """
    for a in range(nodes.size):
        for i in range(3):
            residual[nodes[a], i] += size * weights[a] * direction[i]


@kernel(inline="always")
def spread_on_arm(residual: np.ndarray, base: int, G: np.ndarray, size: float, direction: np.ndarray) -> None:
    """Add a force to the residual, on a point that moves with all unknowns of three nodes of a discrete rod.

    Args:
        residual: shape [nodes, 4].
        base: first of the three nodes.
        G: gradient of the point by their unknowns, shape [3, 12].
        size: of the force.
        direction: of the force, shape [3].
    """
    for c in range(12):
        along = G[0, c] * direction[0] + G[1, c] * direction[1] + G[2, c] * direction[2]
        residual[base + c // 4, c % 4] += size * along


@kernel(inline="always")
def spread_rates_on_arm(G: np.ndarray, size: float, rates: np.ndarray, block: np.ndarray) -> None:
    """Derivatives of what a force adds to the residual, of a point as in `spread_on_arm`, which stays as it is.

    Args:
        G: gradient of the point, shape [3, 12].
        size: of the force.
        rates: derivatives of its direction by n unknowns, shape [3, n].
        block: filled, shape [12, n].
    """
    for a in range(12):
        for c in range(rates.shape[1]):
            block[a, c] = size * (G[0, a] * rates[0, c] + G[1, a] * rates[1, c] + G[2, a] * rates[2, c])
