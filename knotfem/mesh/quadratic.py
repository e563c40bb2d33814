"""Cross-sections of nine-node quadrilaterals: nodes on edges and centres too, on the boundary's circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from knotfem.mesh.section import Section

FloatArray = NDArray[np.float64]

NODES = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0], [0, 0]], dtype=np.int64)
"""Reference coordinates of the nodes of a quadrilateral, shape (9, 2)."""

_SQUARE = np.sqrt(np.pi / 10.0)


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


def shapes(at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Biquadratic shape functions, shape (p, 9), and their rates, shape (p, 9, 2), at points of shape (p, 2)."""
    x = at[:, None, :]
    value = np.select([NODES == -1, NODES == 0, NODES == 1], [0.5 * x * (x - 1), 1 - x * x, 0.5 * x * (x + 1)])
    rate = np.select([NODES == -1, NODES == 0, NODES == 1], [x - 0.5, -2 * x, x + 0.5])
    return value.prod(axis=2), np.stack([rate[..., 0] * value[..., 1], value[..., 0] * rate[..., 1]], axis=2)


def moments(section: Section) -> tuple[float, float, float, float]:
    """Area and integrals of y^2, x^2 and x y over a unit section, as 3 x 3 points see it."""
    line, weight = np.polynomial.legendre.leggauss(3)
    at = np.array([(x, y) for y in line for x in line])
    value, rate = shapes(at)
    corners = section.points[section.quads]
    jacobian = np.linalg.det(np.einsum("qai,pak->qpik", corners, rate))
    share = jacobian * np.outer(weight, weight).ravel()
    x, y = np.moveaxis(np.einsum("qai,pa->qpi", corners, value), -1, 0)
    sums = (share.sum(), (share * y * y).sum(), (share * x * x).sum(), (share * x * y).sum())
    return float(sums[0]), float(sums[1]), float(sums[2]), float(sums[3])


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
