"""Smoothing of a cross-section: elements as square and as equal in area as the layout allows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from knotfem.mesh.section import Section, regular_polygon

FloatArray = NDArray[np.float64]

_EVENNESS = 0.5
_SAME = 1e-5
"""Distance [radii] of places that symmetry makes one: far above what the minimum is found to, far below a spacing."""
_SMALL = 0.01  # unknowns in hundredths of the radius keep the first step short of an inversion


def smooth(section: Section) -> Section:
    """Move the inner nodes to the least distortion, with axis and boundary held and the square's symmetry exact.

    The distortion, summed over the corners of all quadrilaterals with T the corner's Jacobian over the root of the mean
    element area, is `|T|^2 / (2 det T) + w (det T + 1 / det T) / 2`: shape (the inverse mean ratio) plus evenness.

    Args:
        section: a valid section with the eight-fold mirror symmetry of the square.

    Returns:
        The section with the same topology and numbering.
    """
    from scipy.optimize import minimize

    points = section.points.copy()
    points[section.ring] = regular_polygon(len(section.ring))
    free = np.setdiff1d(np.arange(len(points)), np.append(section.ring, section.axis))
    if len(free):

        def objective(unknowns: FloatArray) -> tuple[float, FloatArray]:
            trial = points.copy()
            trial[free] = _SMALL * unknowns.reshape(-1, 2)
            value, gradient = _distortion(trial, section.quads)
            return value, _SMALL * gradient[free].ravel()

        options = {"maxiter": 2000, "ftol": 1e-15, "gtol": 1e-10}
        found = minimize(objective, points[free].ravel() / _SMALL, jac=True, method="L-BFGS-B", options=options)
        points[free] = _SMALL * found.x.reshape(-1, 2)
    return replace(section, points=_symmetric(points))


def _distortion(points: FloatArray, quads: NDArray[np.int64]) -> tuple[float, FloatArray]:
    """Distortion and its gradient with respect to the nodes, shape (m, 2); infinite for an inverted corner."""
    corners = points[quads]
    ahead, behind = np.roll(quads, -1, axis=1), np.roll(quads, 1, axis=1)
    a, b = points[ahead] - corners, points[behind] - corners
    det = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    if (det <= 0).any():
        return float("inf"), np.zeros_like(points)
    mean = np.pi / len(quads)
    square = (a**2).sum(-1) + (b**2).sum(-1)
    value = square / (2 * det) + _EVENNESS * (det / mean + mean / det) / 2
    by_det = -square / (2 * det**2) + _EVENNESS * (1 / mean - mean / det**2) / 2
    grad_a = a / det[..., None] + by_det[..., None] * np.stack([b[..., 1], -b[..., 0]], axis=-1)
    grad_b = b / det[..., None] + by_det[..., None] * np.stack([-a[..., 1], a[..., 0]], axis=-1)
    gradient = np.zeros_like(points)
    np.add.at(gradient, ahead, grad_a)
    np.add.at(gradient, behind, grad_b)
    np.add.at(gradient, quads, -grad_a - grad_b)
    return float(value.sum()), gradient


def _symmetric(points: FloatArray) -> FloatArray:
    """Average over each orbit of the square's symmetry group, exact to the last bit."""
    from scipy.spatial import KDTree

    folded = np.sort(np.abs(points), axis=1)
    folded[folded < _SAME] = 0.0
    equal = np.abs(folded[:, 1] - folded[:, 0]) < _SAME
    folded[equal] = folded[equal].mean(axis=1)[:, None]
    orbit = np.array([min(near) for near in KDTree(folded).query_ball_point(folded, _SAME)])
    _, orbit = np.unique(orbit, return_inverse=True)
    count = np.bincount(orbit)
    mean = np.column_stack([np.bincount(orbit, weights=folded[:, i]) / count for i in (0, 1)])
    ordered = np.abs(points[:, 0]) <= np.abs(points[:, 1])
    magnitude = np.where(ordered[:, None], mean[orbit], mean[orbit][:, ::-1])
    return np.copysign(magnitude, np.where(magnitude == 0, 1.0, points))
