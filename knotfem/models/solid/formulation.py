"""Element formulations of extruded rods: reference gradients, weights and pressure functions of one slice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError
from knotfem.mesh.quadratic import shapes as biquadratic

_GAUSS = 1.0 / np.sqrt(3.0)
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
_AXIAL_POINTS = {
    "hex8": (-_GAUSS, _GAUSS),
    "hex8-reduced": (0.0,),
    "hex8-incompatible": (-_GAUSS, _GAUSS),
    "hex27": tuple(np.polynomial.legendre.leggauss(3)[0]),
}

CENTRE = np.array([[*corner, level] for level in (-1.0, 1.0) for corner in _CORNERS]) / 8.0
"""Rates of the trilinear shape functions at the centre, shape [8, 3]."""


@dataclass(frozen=True, eq=False)
class Formulation:
    """Tables of one slice of elements; all slices of a rod are alike.

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


def names() -> list[str]:
    """Known formulations."""
    return list(_AXIAL_POINTS)


def order(name: str) -> int:
    """Order of an element: 2 has nodes on edges, faces and inside, and spans two slices."""
    return 2 if name == "hex27" else 1


def make_formulation(name: str, quads: np.ndarray, height: float) -> Formulation:
    """Tables for quadrilaterals extruded along z.

    `hex8` is the trilinear hexahedron with full (2 x 2 x 2) integration and constant pressure, the equivalent of
    C3D8H. `hex8-reduced` has one point along the rod, which takes the parasitic transverse shear out of bending (the
    rod then bends like a Timoshenko beam with reduced integration) at half the cost; every zero-energy mode of one
    such element needs a section that moves rigidly, so that none is left in a rod. `hex8-incompatible` has full
    integration, linear pressure and nine incompatible modes: bending without parasitic shear, like C3D8IH.

    `hex27` is quadratic with discontinuous linear pressure (Q2/P1), functions of position rather than of the reference
    coordinates (Arnold, Boffi and Falk 2002), and 3 x 3 x 3 points.

    Args:
        name: see `names`.
        quads: node coordinates [mm], shape [quads, 4 or 9, 2].
        height: length along the rod [mm].
    """
    if name not in _AXIAL_POINTS:
        raise InputError("unknown element", key="rods.mesh.element", found=name, expected=", ".join(names()))
    if name == "hex27":
        return _quadratic(quads, height)
    axial = _AXIAL_POINTS[name]
    count, points = quads.shape[0], 4 * len(axial)
    grads = np.empty((count, points, 8, 3))
    weights = np.empty((count, points))
    shapes = np.empty((points, 8))
    point = 0
    for zeta in axial:
        line = np.array([(1 - zeta) / 2, (1 + zeta) / 2])
        for xi, eta in _CORNERS * _GAUSS:
            flat = (1 + _CORNERS[:, 0] * xi) * (1 + _CORNERS[:, 1] * eta) / 4
            d_flat = (
                np.stack(
                    [
                        _CORNERS[:, 0] * (1 + _CORNERS[:, 1] * eta),
                        _CORNERS[:, 1] * (1 + _CORNERS[:, 0] * xi),
                    ],
                    axis=1,
                )
                / 4
            )
            jacobian = np.einsum("qai,ak->qik", quads, d_flat)
            in_plane = np.einsum("ak,qki->qai", d_flat, np.linalg.inv(jacobian))
            for level, sign in enumerate((-1.0, 1.0)):
                nodes = slice(4 * level, 4 * level + 4)
                grads[:, point, nodes, :2] = in_plane * line[level]
                grads[:, point, nodes, 2] = flat * sign / height
                shapes[point, nodes] = flat * line[level]
            weights[:, point] = np.linalg.det(jacobian) * height / len(axial)
            point += 1
    if name == "hex8-incompatible":
        where = np.array([(xi, eta, zeta) for zeta in axial for xi, eta in _CORNERS * _GAUSS])
        psi = linear_modes(where, weights)
        return Formulation(grads, weights, shapes, psi, psi[..., 1:], CENTRE)
    return plain(grads, weights, shapes, np.ones((count, points, 1)))


def _quadratic(quads: np.ndarray, height: float) -> Formulation:
    line, share = np.polynomial.legendre.leggauss(3)
    at = np.array([(x, y) for y in line for x in line])
    flat, rate = biquadratic(at)
    jacobian = np.einsum("qai,pak->qpik", quads, rate)
    in_plane = np.einsum("pak,qpki->qpai", rate, np.linalg.inv(jacobian))
    area = np.linalg.det(jacobian) * np.outer(share, share).ravel()
    levels = np.stack([0.5 * line * (line - 1), 1 - line * line, 0.5 * line * (line + 1)], axis=1)
    slopes = np.stack([line - 0.5, -2 * line, line + 0.5], axis=1) * 2.0 / height
    count = len(quads)
    grads = np.empty((count, 3, 9, 3, 9, 3))
    grads[..., :2] = np.einsum("qpai,zl->qzplai", in_plane, levels)
    grads[..., 2] = np.einsum("pa,zl->zpla", flat, slopes)
    weights = np.einsum("qp,z->qzp", area, 0.5 * height * share).reshape(count, 27)
    shapes = np.einsum("pa,zl->zpla", flat, levels).reshape(27, 27)
    place = np.einsum("qai,pa->qpi", quads, flat)
    place = (place - quads[:, None, 8]) / np.sqrt(area.sum(axis=1))[:, None, None]
    psi = np.ones((count, 3, 9, 4))
    psi[..., 1:3] = place[:, None]
    psi[..., 3] = line[:, None]
    return plain(grads.reshape(count, 27, 27, 3), weights, shapes, psi.reshape(count, 27, 4))


def plain(grads: np.ndarray, weights: np.ndarray, shapes: np.ndarray, psi: np.ndarray) -> Formulation:
    """Tables without incompatible modes; shapes as in `Formulation`."""
    return Formulation(grads, weights, shapes, psi, np.zeros((*weights.shape, 0)), np.zeros((shapes.shape[1], 0)))


def linear_modes(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
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


def lumped_mass(elements: np.ndarray, formulation: Formulation, density: float, nodes: int) -> np.ndarray:
    """Row-sum mass [tonne] of the bulk, shape [nodes].

    Args:
        elements: connectivity, shape [slices, quads, n].
        formulation: tables of one slice.
        density: [tonne/mm^3].
        nodes: length of the result.
    """
    share = density * np.einsum("qp,pa->qa", formulation.weights, formulation.shapes)
    mass = np.zeros(nodes)
    for layer in elements:
        np.add.at(mass, layer, share)
    return mass
