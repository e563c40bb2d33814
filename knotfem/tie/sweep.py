"""Swept state: cross-sections placed along a centreline, close to the equilibrium of the bent solid."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from knotfem.errors import InputError
from knotfem.geometry.measures import vertex_means
from knotfem.geometry.vectors import unit_edges
from knotfem.tie.path import check_target
from knotfem.types import Array


def frame_curvature(points: ArrayLike, frames: ArrayLike) -> Array:
    """Return the components (k1, k2) of the curvature vector dt/ds = k1 d1 + k2 d2 of a polyline.

    At the inner vertices they are exact for chords of a circle; the first and the last vertex take the components of
    their neighbour.

    Args:
        points: centreline vertices, shape (n + 1, 3), mm.
        frames: rows d1, d2, t of every vertex, shape (n + 1, 3, 3).

    Returns:
        Shape (n + 1, 2), 1/mm.

    Raises:
        InputError: wrong shapes, coinciding vertices, frames that are not right-handed and orthonormal.
    """
    vertices = check_target(points)
    axes = _check_frames(frames, len(vertices))
    lengths = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    curvature = np.diff(unit_edges(vertices), axis=0) / (0.5 * (lengths[1:] + lengths[:-1]))[:, None]
    components = np.empty((len(vertices), 2))
    components[1:-1] = np.einsum("ia,ika->ik", curvature, axes[1:-1, :2])
    components[0], components[-1] = components[1], components[-2]
    return components


def swept_state(
    points: ArrayLike,
    frames: ArrayLike,
    section_points: ArrayLike,
    poisson: float = 0.5,
    curvature: ArrayLike | None = None,
    stretch: ArrayLike | None = None,
) -> Array:
    """Return the positions of a cross-section's nodes along a centreline, with the lateral strains of first order.

    Bending strains the fibre at (x, y) by -(k1 x + k2 y). By the Poisson effect the cross-section expands there by
    nu (k1 x + k2 y) in both directions without shear, which is the anticlastic displacement

        u_x = nu (k1 (x^2 - y^2)/2 + k2 x y),    u_y = nu (k1 x y + k2 (y^2 - x^2)/2).

    A stretch lambda scales the cross-section by lambda^-nu beforehand. A node at (0, 0) lies exactly on the centreline.
    Source: Timoshenko and Goodier, Theory of Elasticity (1970), on pure bending of prismatical bars.

    Args:
        points: centreline vertices, shape (n + 1, 3), mm.
        frames: rows d1, d2, t of every vertex, shape (n + 1, 3, 3); rotation-minimising frames
            if the rod has no twist.
        section_points: coordinates of the cross-section's nodes along d1 and d2, shape (m, 2), mm.
        poisson: Poisson's ratio nu, 0.5 for an incompressible rod; with 0 the cross-sections are moved rigidly.
        curvature: k1, k2 at every vertex, shape (n + 1, 2), 1/mm; by default from `frame_curvature`.
        stretch: lambda of every edge, shape (n,); by default 1. A vertex takes the mean of its edges.

    Returns:
        Positions, shape (n + 1, m, 3), mm.

    Raises:
        InputError: wrong shapes, values that are not finite, frames that are not right-handed and orthonormal, or a
            curvature at which neighbouring cross-sections intersect.
    """
    vertices = check_target(points)
    count = len(vertices)
    axes = _check_frames(frames, count)
    section = _check_shape("section_points", section_points, (None, 2))
    if not -1.0 < poisson <= 0.5:
        raise InputError("wrong Poisson's ratio", found=poisson, expected="-1 < nu <= 0.5")
    k = frame_curvature(vertices, axes) if curvature is None else _check_shape("curvature", curvature, (count, 2))
    lateral = np.ones(count) if stretch is None else _lateral_stretch(stretch, count, poisson)
    x, y = lateral[:, None] * section[:, 0], lateral[:, None] * section[:, 1]
    k1, k2 = k[:, :1], k[:, 1:]
    _refuse_intersections(k1 * x + k2 * y, k)
    across = x + poisson * (0.5 * k1 * (x * x - y * y) + k2 * x * y)
    along = y + poisson * (k1 * x * y + 0.5 * k2 * (y * y - x * x))
    return vertices[:, None] + across[:, :, None] * axes[:, None, 0] + along[:, :, None] * axes[:, None, 1]


def _lateral_stretch(stretch: ArrayLike, count: int, poisson: float) -> Array:
    """lambda^-nu at every vertex, shape (count,)."""
    edges = _check_shape("stretch", stretch, (count - 1,))
    if edges.min() <= 0.0:
        raise InputError("a stretch is not positive", found=edges.min())
    return vertex_means(edges) ** -poisson


def _refuse_intersections(shortening: Array, curvature: Array) -> None:
    """Raise InputError where bending shortens a fibre to nothing.

    Args:
        shortening: of the fibres at every vertex by bending, shape (n + 1, m).
        curvature: k1, k2 at every vertex, shape (n + 1, 2), 1/mm.
    """
    if shortening.max() >= 1.0:
        vertex = int(shortening.max(axis=1).argmax())
        raise InputError(
            f"the centreline is curved so sharply at vertex {vertex} that neighbouring sections cut each other",
            found=f"curvature {np.hypot(*curvature[vertex]):.4g} 1/mm, {shortening.max():.3g} of the limit",
            expected="a radius of curvature larger than the rod's radius",
        )


def _check_shape(name: str, values: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    array = np.asarray(values, dtype=float)
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape, strict=True))
    if not fits:
        expected = ", ".join("m" if size is None else str(size) for size in shape)
        raise InputError(f"wrong shape of {name}", found=array.shape, expected=f"({expected})")
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds values that are not finite")
    return array


def _check_frames(frames: ArrayLike, count: int) -> Array:
    axes = _check_shape("frames", frames, (count, 3, 3))
    worst = np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max()
    if worst > 1e-6 or np.linalg.det(axes).min() < 0.0:
        raise InputError(
            "the frames are not right-handed and orthonormal",
            found=f"deviation {worst:.3g}, smallest determinant {np.linalg.det(axes).min():.3g}",
            expected="rows d1, d2, t with t = d1 x d2",
        )
    return axes
