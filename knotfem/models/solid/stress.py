"""Stresses and strains of mixed hexahedra at their integration points, for output."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from knotfem.models.material import Material
from knotfem.models.solid.elasticity import Elasticity
from knotfem.models.solid.projection import Projection

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Components of a symmetric tensor in ParaView's order."""


@dataclass(frozen=True, eq=False)
class StressState:
    """Fields of one rod's bulk at the integration points, shape [slices, quads, points, ...].

    Attributes:
        deformation: F, [..., 3, 3].
        first_piola: P [MPa], [..., 3, 3].
        weights: reference volumes [mm^3], shape [slices, quads, points].
    """

    deformation: np.ndarray
    first_piola: np.ndarray
    weights: np.ndarray

    @cached_property
    def cauchy_points(self) -> np.ndarray:
        """Cauchy stress [MPa] at the integration points, shape [slices, quads, points, 3, 3]."""
        jacobian = np.linalg.det(self.deformation)
        kirchhoff = np.einsum("sqgik,sqgjk->sqgij", self.first_piola, self.deformation)
        return kirchhoff / jacobian[..., None, None]

    @property
    def cauchy(self) -> np.ndarray:
        """Cauchy stress [MPa], volume mean of each hexahedron, shape [slices, quads, 3, 3]."""
        return _mean(self.cauchy_points, self.weights)

    @cached_property
    def right_cauchy_green(self) -> np.ndarray:
        """F^T F at the integration points, shape [slices, quads, points, 3, 3]."""
        return np.einsum("sqgki,sqgkj->sqgij", self.deformation, self.deformation)

    @property
    def largest_principal_strain(self) -> np.ndarray:
        """Largest principal logarithmic strain of each hexahedron's mean, shape [slices, quads]."""
        return largest_strain(_mean(self.right_cauchy_green, self.weights))

    def nodal(self, projection: Projection) -> tuple[np.ndarray, np.ndarray]:
        """Cauchy stress [MPa], shape [nodes, 6], and largest principal logarithmic strain, shape [nodes], projected.

        Args:
            projection: of this rod.
        """
        both = np.concatenate([symmetric(self.cauchy_points), symmetric(self.right_cauchy_green)], axis=-1)
        nodal = projection.nodal(both)
        right = np.empty((len(nodal), 3, 3))
        for k, (i, j) in enumerate(VOIGT):
            right[:, i, j] = right[:, j, i] = nodal[:, 6 + k]
        return nodal[:, :6], largest_strain(right)


def symmetric(tensors: np.ndarray) -> np.ndarray:
    """Components xx, yy, zz, xy, yz, xz of symmetric tensors, shape [..., 6] from [..., 3, 3]."""
    return np.stack([tensors[..., i, j] for i, j in VOIGT], axis=-1)


def largest_strain(right: np.ndarray) -> np.ndarray:
    """Largest principal logarithmic strain of right Cauchy-Green tensors, shape [...] from [..., 3, 3]."""
    return 0.5 * np.log(np.maximum(np.linalg.eigvalsh(right)[..., -1], np.finfo(float).tiny))


def stress_state(x: np.ndarray, elasticity: Elasticity) -> StressState:
    """Evaluate a rod's bulk.

    Args:
        x: positions [mm], shape [nodes, 3].
        elasticity: the rod's bulk with its pressures.
    """
    F, pressure = elasticity.deformation(x), _pressure(elasticity)
    return StressState(F, _first_piola(F, pressure, elasticity.material), elasticity.weights)


def layer_forces(state: StressState, elasticity: Elasticity) -> np.ndarray:
    """Stress integrated across the section, mean over each layer of hexahedra [N], shape [layers, 3]."""
    total = np.einsum("sqgi,sqg->si", state.first_piola[..., 2], state.weights)
    return total / elasticity.layer_heights[:, None]


def middle_forces(state: StressState, elasticity: Elasticity) -> np.ndarray:
    """Stress integrated across the middle of each slice of trilinear hexahedra [N], shape [slices, 3].

    Halfway along, bending leaves no parasitic shear: there the stress is most accurate (Barlow 1976). The deformation
    gradient is linear along the slice, so that its mean over the planes of integration points is that of the middle.

    Args:
        state: of the bulk.
        elasticity: the bulk, of eight-node hexahedra.
    """
    F, pressure = _along(state.deformation, 2), _along(_pressure(elasticity), 2)
    P = _first_piola(F.mean(axis=2), pressure.mean(axis=2), elasticity.material)
    area = _along(state.weights, 2).sum(axis=2) / elasticity.layer_heights[:, None, None]
    return np.einsum("sqgi,sqg->si", P[..., 2], area)


def _along(values: np.ndarray, axis: int) -> np.ndarray:
    """Integration points, at `axis`, as planes of four."""
    return values.reshape(*values.shape[:axis], -1, 4, *values.shape[axis + 1 :])


def _pressure(elasticity: Elasticity) -> np.ndarray:
    """At the integration points [MPa], shape [slices, quads, points]."""
    return np.einsum("qgm,sqm->sqg", elasticity.formulation.psi, elasticity.pressure)


def _first_piola(F: np.ndarray, pressure: np.ndarray, material: Material) -> np.ndarray:
    """P = 2 W' J^(-2/3) F + (p J - 2 W' I1 / 3) F^-T, shapes [..., 3, 3] and [...]."""
    J = np.linalg.det(F)
    inverse_t = np.linalg.inv(F).swapaxes(-1, -2)
    shrunk = J ** (-2.0 / 3.0)
    square = np.einsum("...ik,...ik->...", F, F)
    modulus = material.shear_modulus if material.linear else 2.0 * material.first(shrunk * square)
    scale = modulus * shrunk
    spherical = pressure * J - scale * square / 3.0
    return scale[..., None, None] * F + spherical[..., None, None] * inverse_t


def _mean(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.einsum("sqgij,sqg->sqij", values, weights) / weights.sum(axis=2)[..., None, None]
