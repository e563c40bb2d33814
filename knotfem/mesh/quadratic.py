"""Cross-sections of nine-node quadrilaterals: nodes on edges and centres too, on the boundary's circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from knotfem.mesh.section import Section

FloatArray = NDArray[np.float64]

FIVE = 5
"""Quadrilaterals of the coarsest disc that has no node of less than three."""
_SQUARE = np.sqrt(np.pi / 10.0)
"""Half the diagonal of a square whose area is a fifth of the circle's."""


def five() -> Section:
    """Five nine-node quadrilaterals of about equal area: a square around the axis and four around it."""
    angle = np.pi * (0.25 + 0.5 * np.arange(4))
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    corners = np.concatenate([_SQUARE * ring, ring])
    quads = [[0, 1, 2, 3], *([i, 4 + i, 4 + (i + 1) % 4, (i + 1) % 4] for i in range(4))]
    return _raise(corners, np.array(quads))


def quadratic(section: Section) -> Section:
    """The same quadrilaterals with nine nodes each; those of four are taken as they are cut.

    Args:
        section: of four-node quadrilaterals.
    """
    return _raise(section.points, section.quads)


def _raise(points: FloatArray, quads: NDArray[np.int64]) -> Section:
    following = np.roll(quads, -1, axis=1)
    edges, which, uses = np.unique(
        np.sort(np.stack([quads, following], axis=-1).reshape(-1, 2), axis=1),
        axis=0,
        return_inverse=True,
        return_counts=True,
    )
    middle = points[edges].mean(axis=1)
    outer = uses == 1
    middle[outer] /= np.linalg.norm(middle[outer], axis=1)[:, None]
    which = which.reshape(quads.shape)
    centre = 0.5 * middle[which].sum(axis=1) - 0.25 * points[quads].sum(axis=1)
    first = len(points)
    nodes = np.concatenate([points, middle, centre])
    nine = np.concatenate([quads, first + which, (first + len(edges) + np.arange(len(quads)))[:, None]], axis=1)
    axis = int(np.argmin(np.hypot(*nodes.T)))
    boundary = np.unique(np.concatenate([edges[outer].ravel(), first + np.flatnonzero(outer)]))
    angle = np.mod(np.arctan2(nodes[boundary, 1], nodes[boundary, 0]) + 1e-9, 2 * np.pi)
    ring = boundary[np.argsort(angle)]
    order = np.append(axis, np.delete(np.arange(len(nodes)), axis))
    number = np.argsort(order)
    nodes = nodes[order]
    nodes[0] = 0.0
    return Section(nodes, number[nine], 0, number[ring])
