"""Stresses and strains of mixed hexahedra at their integration points, for output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.effects.elasticity import Elasticity


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
    form = elasticity.formulation
    F = elasticity.deformation(x)
    J = np.linalg.det(F)
    inverse_t = np.linalg.inv(F).swapaxes(-1, -2)
    b_trace = np.einsum("sqgik,sqgik->sqg", F, F)
    scale = elasticity.shear_modulus * J ** (-2.0 / 3.0)
    pressure = np.einsum("qgm,sqm->sqg", form.psi, elasticity.pressure)
    spherical = pressure * J - scale * b_trace / 3.0
    P = scale[..., None, None] * F + spherical[..., None, None] * inverse_t
    return StressState(F, P, form.weights)


def _mean(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return np.einsum("sqgij,qg->sqij", values, weights) / weights.sum(axis=1)[None, :, None, None]
