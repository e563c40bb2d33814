"""Nearly incompressible neo-Hookean hexahedra in a mixed form equivalent to C3D8H."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.effects import hexahedra
from knotfem.effects.formulation import Formulation
from knotfem.solver.effect import Arrays, Effect
from knotfem.solver.sparsity import Matrix, Pattern, element_keys

MERIT_BULK_OVER_SHEAR = 20.0


@dataclass
class Elasticity(Effect):
    """The bulk of one rod.

    W = mu/2 (J^(-2/3) tr C - 3) + p (J - 1) - p^2 / (2 kappa), the pressure p an unknown of each element.

    Args:
        elements: connectivity, shape [slices, quads, n].
        formulation: tables of one slice.
        shear_modulus: mu [MPa].
        bulk_modulus: kappa [MPa].
    """

    elements: np.ndarray
    formulation: Formulation
    shear_modulus: float
    bulk_modulus: float

    def __post_init__(self) -> None:
        self.name = "elasticity"
        slices, quads, count = self.elements.shape
        psi, weights = self.formulation.psi, self.formulation.weights
        modes = psi.shape[1]
        compliance = np.einsum("pi,pj,ep->eij", psi, psi, weights) / self.bulk_modulus
        self._compliance_inv = np.linalg.inv(compliance)
        self._compliance = compliance
        self._slots = np.empty((slices * quads, count, count), dtype=np.int32)
        self._b = np.zeros((slices, quads, modes, 3 * count))
        self._excess = np.zeros((slices, quads, modes))
        self._dp = np.zeros((slices, quads, modes))
        self.pressure = np.zeros((slices, quads, modes))
        self.smallest_j = 1.0

    def keys(self, nodes: int) -> np.ndarray:
        return element_keys(self.elements.reshape(-1, self.elements.shape[2]), nodes)

    def bind(self, pattern: Pattern) -> None:
        flat = self.elements.reshape(-1, self.elements.shape[2])
        hexahedra.element_slots(flat, pattern.node_ptr, pattern.node_adj, self._slots)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        pattern = matrix.pattern if matrix is not None else _NO_PATTERN
        self.smallest_j = hexahedra.assemble(
            x,
            self.elements,
            self.formulation.grads,
            self.formulation.weights,
            self.formulation.psi,
            self._compliance_inv,
            self.shear_modulus,
            self.pressure,
            residual,
            matrix is not None,
            matrix.data if matrix is not None else _NO_DATA,
            self._slots,
            pattern.node_ptr,
            pattern.upper,
            self._b,
            self._excess,
        )
        return True

    def increment(self, du: np.ndarray) -> None:
        hexahedra.pressure_increment(du, self.elements, self._compliance_inv, self._b, self._excess, self._dp)

    def advance(self, fraction: float) -> None:
        self.pressure += fraction * self._dp

    def merit(self, x: np.ndarray) -> float:
        modulus = MERIT_BULK_OVER_SHEAR * self.shear_modulus
        value, smallest = self._potential(x, self.pressure + self._dp, modulus)
        return value if smallest > 0.0 else np.inf

    def energy(self, x: np.ndarray) -> float:
        value, _ = self._potential(x, self.pressure, 0.0)
        return value - 0.5 * float(np.einsum("sei,eij,sej->", self.pressure, self._compliance, self.pressure))

    def memory(self) -> Arrays:
        return {"pressure": self.pressure.copy()}

    def recall(self, memory: Arrays) -> None:
        self.pressure[:] = memory["pressure"]

    def _potential(self, x: np.ndarray, pressure: np.ndarray, modulus: float) -> tuple[float, float]:
        form = self.formulation
        return hexahedra.merit(
            x, self.elements, form.grads, form.weights, form.psi, self.shear_modulus, pressure, modulus
        )


_NO_DATA = np.zeros(0)
_NO_PATTERN = Pattern(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), False)
