"""Contact pressure on the surface nodes of hexahedra."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from knotfem.contact.obstacle import ObstacleContact
from knotfem.contact.pairs import PairContact
from knotfem.solver.term import Term


def contact_pressure(nodes: int, terms: Sequence[Term]) -> np.ndarray:
    """Normal contact force of the samples spread on their nodes, over the nodes' part of the surface [MPa]."""
    force, area = np.zeros(nodes), np.zeros(nodes)
    for term in terms:
        if isinstance(term, PairContact):
            samples = term.samples.view
            weights = np.maximum(samples.weights, 0.0)
            np.add.at(area, samples.nodes, weights * samples.measure[:, None])
            touching = term.pairs.sample
            np.add.at(force, samples.nodes[touching], 2.0 * weights[touching] * term.pairs.force[:, None])
        elif isinstance(term, ObstacleContact):
            samples, near = term.samples.view, term.touch.sample
            weights = np.maximum(samples.weights[near], 0.0)
            np.add.at(force, samples.nodes[near], weights * term.touch.force[near][:, None])
    return np.divide(force, area, out=np.zeros_like(force), where=area > 0.0)
