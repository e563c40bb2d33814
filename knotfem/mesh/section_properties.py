"""Area and second moments of a cross-section, and the scale that gives it the circle's bending stiffness."""

from __future__ import annotations

import numpy as np

from knotfem.mesh.section import Section


def area(section: Section) -> float:
    """Area of the unit section as its elements fill it (pi for the circle)."""
    if section.order == 2:
        return _moments(section)[0]
    x, y = section.points[section.ring].T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def second_moments(section: Section) -> tuple[float, float, float]:
    """Second moments of area (I_xx, I_yy, I_xy) = integrals of (y^2, x^2, x y) over the facetted unit section.

    The circle has pi/4, pi/4, 0.
    """
    if section.order == 2:
        return _moments(section)[1:]
    x0, y0 = section.points[section.ring].T
    x1, y1 = np.roll(x0, -1), np.roll(y0, -1)
    cross = x0 * y1 - x1 * y0
    return (
        float(np.sum(cross * (y0 * y0 + y0 * y1 + y1 * y1)) / 12),
        float(np.sum(cross * (x0 * x0 + x0 * x1 + x1 * x1)) / 12),
        float(np.sum(cross * (x0 * y1 + 2 * x0 * y0 + 2 * x1 * y1 + x1 * y0)) / 24),
    )


def scale_for_bending(section: Section) -> float:
    """Node radius over rod radius for which the facetted section has the circle's second moment pi r^4 / 4.

    Returns:
        The dimensionless factor, slightly above one: 1.0129 for 16 facets.
    """
    i_xx, i_yy, _ = second_moments(section)
    return float((np.pi / 4 / (0.5 * (i_xx + i_yy))) ** 0.25)


def _moments(section: Section) -> tuple[float, float, float, float]:
    """Area and integrals of y^2, x^2 and x y over nine-node quadrilaterals, by 3 x 3 Gauss points."""
    from knotfem.mesh.reference import gauss_square, quadrilateral

    points, weights = gauss_square(3)
    values, rates = quadrilateral(2).at(points)
    nodes = section.points[section.quads]
    jacobian = np.linalg.det(np.einsum("qai,pak->qpik", nodes, rates))
    parts = jacobian * weights
    x, y = np.moveaxis(np.einsum("qai,pa->qpi", nodes, values), -1, 0)
    sums = (parts.sum(), (parts * y * y).sum(), (parts * x * x).sum(), (parts * x * y).sum())
    return float(sums[0]), float(sums[1]), float(sums[2]), float(sums[3])
