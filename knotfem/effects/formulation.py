"""Element formulations of extruded rods: reference gradients, weights and pressure functions of one slice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.errors import InputError

_GAUSS = 1.0 / np.sqrt(3.0)
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
_AXIAL_POINTS = {"hex8": (-_GAUSS, _GAUSS), "hex8-reduced": (0.0,)}


@dataclass(frozen=True, eq=False)
class Formulation:
    """Tables of one slice of elements; all slices of a rod are alike.

    Attributes:
        grads: reference gradients [1/mm], shape [quads, points, n, 3].
        weights: reference volumes [mm^3], shape [quads, points].
        shapes: shape functions at the points, shape [points, n].
        psi: pressure functions at the points, shape [points, q].
    """

    grads: np.ndarray
    weights: np.ndarray
    shapes: np.ndarray
    psi: np.ndarray


def names() -> list[str]:
    """Known formulations."""
    return list(_AXIAL_POINTS)


def make_formulation(name: str, quads: np.ndarray, height: float) -> Formulation:
    """Tables for quadrilaterals extruded along z.

    `hex8` is the trilinear hexahedron with full (2 x 2 x 2) integration and constant pressure, the equivalent of
    C3D8H. `hex8-reduced` has one point along the rod, which takes the parasitic transverse shear out of bending (the
    rod then bends like a Timoshenko beam with reduced integration) at half the cost; every zero-energy mode of one
    such element needs a section that moves rigidly, so that none is left in a rod.

    Args:
        name: see `names`.
        quads: corner coordinates [mm], counter-clockwise, shape [quads, 4, 2].
        height: slice length [mm].
    """
    if name not in _AXIAL_POINTS:
        raise InputError("unknown element", key="rods.mesh.element", found=name, expected=", ".join(names()))
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
    return Formulation(grads, weights, shapes, np.ones((points, 1)))


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
