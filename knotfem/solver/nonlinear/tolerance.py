"""When a state is in balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Imbalance:
    """How far a state is from balance.

    Attributes:
        residual: largest out-of-balance force of one free unknown [N].
        resultant: largest out-of-balance force summed over all nodes up to any cross-section of a rod [N].
    """

    residual: float = np.inf
    resultant: float = np.inf


@dataclass(frozen=True)
class ForceTolerance:
    """Convergence on nodes and on resultants.

    Small coherent residuals of many nodes would add up to a force that the nodes themselves do not show: with a
    tolerance on nodes alone end forces differed by up to 8 %.

    Attributes:
        node: largest out-of-balance force of one unknown [N].
        resultant: largest out-of-balance force summed over all nodes up to any cross-section of a rod [N].
    """

    node: float = 1e-5
    resultant: float = 1e-4

    @classmethod
    def of(cls, node: float) -> ForceTolerance:
        """That of a node [N], and ten times as much for resultants."""
        return cls(node, 10.0 * node)

    def excess(self, imbalance: Imbalance) -> float:
        """Imbalance over tolerance; below 1 a state is in balance."""
        return max(imbalance.residual / self.node, imbalance.resultant / self.resultant)

    def loosened(self, node: float) -> ForceTolerance:
        """At least `node` [N], resultants in proportion."""
        factor = max(1.0, node / self.node)
        return ForceTolerance(factor * self.node, factor * self.resultant)


@dataclass(frozen=True, eq=False)
class Sections:
    """Cross-sections of all rods, over which resultants are summed.

    Attributes:
        of_node: cross-section of each node, counted through all rods, shape [nodes].
        first: first cross-section of each rod, shape [rods].
    """

    of_node: np.ndarray
    first: np.ndarray

    @classmethod
    def single(cls, of_node: np.ndarray) -> Sections:
        """Those of one rod."""
        return cls(of_node, np.zeros(1, dtype=np.int64))

    def running_sums(self, forces: np.ndarray) -> np.ndarray:
        """Forces summed from the start of each rod up to each of its cross-sections, shape [sections, 3].

        Args:
            forces: on nodes, shape [nodes, width]; the first three components are summed.
        """
        sums = np.stack([np.bincount(self.of_node, weights=forces[:, i]) for i in range(3)], axis=1)
        if self.first.size == 1:
            return np.cumsum(sums, axis=0)
        return np.concatenate([np.cumsum(part, axis=0) for part in np.split(sums, self.first[1:])])

    def largest_sum(self, forces: np.ndarray) -> float:
        """Size of the largest of them [N]."""
        return float(np.linalg.norm(self.running_sums(forces), axis=1).max())


def imbalance(residual: np.ndarray, fixed: np.ndarray, sections: Sections) -> Imbalance:
    """How far a state is from balance.

    Args:
        residual: shape [nodes, width].
        fixed: prescribed unknowns, shape [nodes, width].
        sections: over which resultants are summed, rod by rod.
    """
    free = np.where(fixed, 0.0, residual)
    return Imbalance(float(np.abs(free).max()), sections.largest_sum(free))
