"""Element formulations of extruded rods: reference gradients, weights and pressure functions of one slice.

Shape functions and quadrature are scikit-fem's (`knotfem.mesh.reference`). Names and orders stand in
`knotfem.scene.elements`:

- `hex8`, the trilinear hexahedron with full (2 x 2 x 2) integration and constant pressure, the equivalent of C3D8H;
- `hex8-reduced`, with one point along the rod, which takes the parasitic transverse shear out of bending (the rod then
  bends like a Timoshenko beam with reduced integration) at half the cost; every zero-energy mode of one such element
  needs a section that moves rigidly, so that none is left in a rod;
- `hex8-incompatible`, with full integration, linear pressure and nine incompatible modes: bending without parasitic
  shear, like C3D8IH;
- `hex27`, quadratic with discontinuous linear pressure (Q2/P1), functions of position rather than of the reference
  coordinates (Arnold, Boffi and Falk 2002), and 3 x 3 x 3 points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.mesh.reference import gauss_line, gauss_square, hexahedron
from knotfem.scene.elements import ORDERS

_POINTS = {"hex8": (2, 2), "hex8-reduced": (2, 1), "hex8-incompatible": (2, 2), "hex27": (3, 3)}
"""Gauss points along a side of the quadrilateral, and along the rod."""


@dataclass(frozen=True, eq=False)
class Formulation:
    """Tables of one layer of elements; others of the rod differ from it in their length only.

    Attributes:
        grads: reference gradients [1/mm], shape [quads, points, n, 3].
        weights: reference volumes [mm^3], shape [quads, points].
        shapes: shape functions at the points, shape [points, n].
        psi: pressure functions at the points, shape [quads, points, q].
        modes: functions of incompatible modes at the points, shape [quads, points, k].
        centre: rates of the shape functions in reference coordinates at the centre, shape [n, k].
    """

    grads: np.ndarray
    weights: np.ndarray
    shapes: np.ndarray
    psi: np.ndarray
    modes: np.ndarray
    centre: np.ndarray


def make_formulation(name: str, quads: np.ndarray, height: float) -> Formulation:
    """Tables for quadrilaterals extruded along z.

    Args:
        name: of the element, a key of `ORDERS`.
        quads: node coordinates [mm], shape [quads, 4 or 9, 2].
        height: length along the rod [mm].

    Raises:
        InputError: no element has this name.
    """
    if name not in _POINTS:
        raise InputError("unknown element", key="rods.mesh.element", found=name, expected=", ".join(_POINTS))
    levels = np.linspace(0.0, height, ORDERS[name] + 1)
    nodes = np.concatenate([np.dstack([quads, np.full(quads.shape[:2], level)]) for level in levels], axis=1)
    return brick_formulation(name, nodes) if ORDERS[name] == 1 else _quadratic(nodes, height)


def brick_formulation(name: str, nodes: np.ndarray) -> Formulation:
    """Tables for eight-node hexahedra of any shape.

    Args:
        name: of the element.
        nodes: of each hexahedron, level after level [mm], shape [hexes, 8, 3].
    """
    points, weights = _extruded_points(*_POINTS[name])
    grads, volumes, shapes = _tables(nodes, points, weights)
    if name != "hex8-incompatible":
        return _plain(grads, volumes, shapes, np.ones((*volumes.shape, 1)))
    psi = _linear_modes(points, volumes)
    _, centre = hexahedron(1).at(np.zeros((1, 3)))
    return Formulation(grads, volumes, shapes, psi, psi[..., 1:], centre[0])


def _quadratic(nodes: np.ndarray, height: float) -> Formulation:
    points, weights = _extruded_points(*_POINTS["hex27"])
    grads, volumes, shapes = _tables(nodes, points, weights)
    places = np.einsum("qai,pa->qpi", nodes[..., :2], shapes) - nodes[:, None, 8, :2]
    psi = np.ones((*volumes.shape, 4))
    psi[..., 1:3] = places / np.sqrt(volumes.sum(axis=1) / height)[:, None, None]
    psi[..., 3] = points[:, 2]
    return _plain(grads, volumes, shapes, psi)


def _extruded_points(across: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points of a quadrilateral, level after level along z, shape [points, 3], and their weights.

    Args:
        across: points along a side of the quadrilateral.
        along: levels.
    """
    flat, flat_weights = gauss_square(across)
    line, line_weights = gauss_line(along)
    points = np.column_stack([np.tile(flat, (along, 1)), np.repeat(line, len(flat))])
    return points, np.outer(line_weights, flat_weights).ravel()


def _tables(nodes: np.ndarray, points: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reference gradients, volumes and shape functions of hexahedra of any shape, as `Formulation` has them.

    Args:
        nodes: of each hexahedron, level after level [mm], shape [hexes, 8 or 27, 3].
        points: of integration in [-1, 1]^3, shape [points, 3].
        weights: of the points, shape [points].
    """
    shapes, rates = hexahedron(1 if nodes.shape[1] == 8 else 2).at(points)
    jacobian = np.einsum("eai,pak->epik", nodes, rates)
    grads = np.einsum("pak,epki->epai", rates, np.linalg.inv(jacobian))
    return grads, np.linalg.det(jacobian) * weights, shapes


def _plain(grads: np.ndarray, weights: np.ndarray, shapes: np.ndarray, psi: np.ndarray) -> Formulation:
    """Tables without incompatible modes; shapes as in `Formulation`."""
    return Formulation(grads, weights, shapes, psi, np.zeros((*weights.shape, 0)), np.zeros((shapes.shape[1], 0)))


def _linear_modes(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Functions 1 and xi_m less its mean over the element, shape [hexes, points, 4].

    Without a mean, modes made of them pass the patch test whatever the element's shape (Taylor, Beresford and Wilson
    1976). Taking the mean off keeps the one along an extruded element linear, as bending wants it, which a factor
    j_0 / j does not.

    Args:
        points: of integration in [-1, 1]^3, shape [points, 3].
        weights: reference volumes [mm^3], shape [hexes, points].
    """
    mean = weights @ points / weights.sum(axis=1)[:, None]
    return np.concatenate([np.ones((*weights.shape, 1)), points - mean[:, None]], axis=2)


def lumped_mass(
    elements: np.ndarray, formulation: Formulation, density: float, nodes: int, heights: np.ndarray | None = None
) -> np.ndarray:
    """Row-sum mass [tonne] of the bulk, shape [nodes].

    Args:
        elements: connectivity, shape [slices, quads, n].
        formulation: tables of one layer.
        density: [tonne/mm^3].
        nodes: length of the result.
        heights: lengths of the layers over that of the tables, shape [slices]; None for layers as long as these.
    """
    share = density * np.einsum("qp,pa->qa", formulation.weights, formulation.shapes)
    mass = np.zeros(nodes)
    for layer, height in zip(elements, np.ones(len(elements)) if heights is None else heights, strict=True):
        np.add.at(mass, layer, height * share)
    return mass
