"""Samples: fixed material points of the rods' surfaces or centrelines at which contact is looked for.

Their place is linear in the positions of a few nodes. Each stands for a part of the surface [mm^2] or of the
centreline [mm], so that contact forces are integrals over the reference configuration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from knotfem.compiled import kernel


class SampleView(NamedTuple):
    """What compiled loops need of samples.

    Attributes:
        rod: shape [samples].
        at: parameters on the surface, the first in segments along the rod, shape [samples, parameters].
        nodes: shape [samples, n].
        weights: of the nodes in the place, shape [samples, n].
        rates: of the nodes in the first derivative along the rod, shape [samples, n]; empty for surfaces.
        between: where between the middles of its two segments a sample of a centreline lies, 0 to 1, shape [samples].
        measure: that each stands for [mm^2 or mm], shape [samples].
        offset: distance of the surface from the sample [mm]; the radius for centrelines, shape [samples].
    """

    rod: np.ndarray
    at: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    rates: np.ndarray
    between: np.ndarray
    measure: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of all rods.

    Attributes:
        view: their arrays.
        start: first sample nearest to each station (cross-section or node), stations of all rods one behind the other,
            and the number of all samples, shape [stations + 1].
    """

    view: SampleView
    start: np.ndarray

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.view.rod.size

    @property
    def rod(self) -> np.ndarray:
        """Rod of each sample, shape [samples]."""
        return self.view.rod

    @property
    def u(self) -> np.ndarray:
        """Coordinate of each sample along its rod in segments, shape [samples]."""
        return self.view.at[:, 0]

    def places(self, x: np.ndarray) -> np.ndarray:
        """Places of all samples [mm] at positions of the nodes, shape [samples, 3]."""
        points = np.empty((self.count, 3))
        sample_points(x, self.view.nodes, self.view.weights, points)
        return points


@kernel
def sample_points(x: np.ndarray, nodes: np.ndarray, weights: np.ndarray, out: np.ndarray) -> None:
    """Places of samples into out, shape [samples, 3]."""
    for s in range(nodes.shape[0]):
        for i in range(3):
            value = 0.0
            for a in range(nodes.shape[1]):
                value += weights[s, a] * x[nodes[s, a], i]
            out[s, i] = value
