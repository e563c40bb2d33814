"""Stresses and strains of mixed hexahedra at their integration points, for output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.models.material import Material
from knotfem.models.solid.elasticity import Elasticity


@dataclass(frozen=True, eq=False)
class StressState:
    """Fields of one rod's bulk at the integration points, shape [slices, quads, points, ...].

    Attributes:
        deformation: F, [..., 3, 3].
        first_piola: P [MPa], [..., 3, 3].
        weights: reference volumes [mm^3], shape [quads, points].
    """

    deformation: np.ndarray
    first_piola: np.ndarray
    weights: np.ndarray

    @property
    def cauchy(self) -> np.ndarray:
        """Cauchy stress [MPa], volume mean of each hexahedron, shape [slices, quads, 3, 3]."""
        jacobian = np.linalg.det(self.deformation)
        kirchhoff = np.einsum("sqgik,sqgjk->sqgij", self.first_piola, self.deformation)
        return _mean(kirchhoff / jacobian[..., None, None], self.weights)

    @property
    def largest_principal_strain(self) -> np.ndarray:
        """Largest principal logarithmic strain of each hexahedron's mean, shape [slices, quads]."""
        right = np.einsum("sqgki,sqgkj->sqgij", self.deformation, self.deformation)
        return 0.5 * np.log(np.linalg.eigvalsh(_mean(right, self.weights))[..., -1])


def stress_state(x: np.ndarray, elasticity: Elasticity) -> StressState:
    """Evaluate a rod's bulk.

    Args:
        x: positions [mm], shape [nodes, 3].
        elasticity: the rod's bulk with its pressures.
    """
    F, pressure = elasticity.deformation(x), _pressure(elasticity)
    return StressState(F, _first_piola(F, pressure, elasticity.material), elasticity.formulation.weights)


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
    area = _along(state.weights, 1).sum(axis=1) / elasticity.layer_height
    return np.einsum("sqgi,qg->si", P[..., 2], area)


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
    return np.einsum("sqgij,qg->sqij", values, weights) / weights.sum(axis=1)[None, :, None, None]
