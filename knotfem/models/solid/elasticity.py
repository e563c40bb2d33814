"""Nearly incompressible neo-Hookean hexahedra in a mixed form equivalent to C3D8H."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from knotfem.models.solid import hexahedra
from knotfem.models.solid.formulation import Formulation
from knotfem.solver.term import Arrays, Term
from knotfem.sparse.pattern import Matrix, Pattern, element_keys

MERIT_BULK_OVER_SHEAR = 20.0


@dataclass
class Elasticity(Term):
    """The bulk of one rod.

    W = mu/2 (J^(-2/3) tr C - 3) + p (J - 1) - p^2 / (2 kappa), the pressure p an unknown of each element. Incompatible
    modes, where the formulation has them, are unknowns of each element too; see `hexahedra`.

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
        modes, extra = psi.shape[2], self.formulation.modes.shape[2]
        compliance = np.einsum("epi,epj,ep->eij", psi, psi, weights) / self.bulk_modulus
        self._compliance_inv = np.linalg.inv(compliance)
        self._compliance = compliance
        self._slots = np.empty((slices * quads, count, count), dtype=np.int32)
        self._b = np.zeros((slices, quads, modes, 3 * (count + extra)))
        self._excess = np.zeros((slices, quads, modes))
        self._dp = np.zeros((slices, quads, modes))
        self.pressure = np.zeros((slices, quads, modes))
        self.modes = np.zeros((slices, quads, extra, 3))
        self._change = np.zeros_like(self.modes)
        self._trial = np.zeros_like(self.modes)
        self._follow = np.zeros((slices, quads, 3 * extra, 3 * count + 1))
        self._expanded: np.ndarray | None = None
        self.smallest_j = 1.0

    @property
    def layer_height(self) -> float:
        """Length of a hexahedron along the rod [mm]: two over the axial gradient of its reference coordinate."""
        count = self.elements.shape[2]
        levels = 2 if count == 8 else 3
        level = np.repeat(np.linspace(-1.0, 1.0, levels), count // levels)
        return float(2.0 / (self.formulation.grads[0, 0, :, 2] @ level))

    @property
    def admissible(self) -> bool:
        return self.smallest_j > 0.0

    def forget(self) -> None:
        """Set pressures and modes back to those of an unstressed rod; the next solve finds them anew."""
        self.pressure[:] = 0.0
        self.modes[:] = 0.0

    def deformation(self, x: np.ndarray) -> np.ndarray:
        """Deformation gradients at the integration points, shape [slices, quads, points, 3, 3]."""
        form, places = self.formulation, x[self.elements]
        F = np.einsum("sqai,qgak->sqgik", places, form.grads)
        tangents = np.einsum("am,sqai->sqmi", form.centre, places)
        return F + np.einsum("qgm,sqmi,sqmk->sqgik", form.modes, tangents, self.modes)

    def nodal_forces(self, x: np.ndarray, stress: np.ndarray) -> np.ndarray:
        """Forces on the nodes of each hexahedron [N], shape [slices, quads, n, 3].

        Args:
            x: positions [mm], shape [nodes, 3].
            stress: first Piola-Kirchhoff stress times volume, shape [slices, quads, points, 3, 3].
        """
        form = self.formulation
        direct = np.einsum("sqgik,qgak->sqai", stress, form.grads)
        turned = np.einsum("sqgik,qgm,sqmk->sqmi", stress, form.modes, self.modes)
        return direct + np.einsum("sqmi,am->sqai", turned, form.centre)

    def couplings(self, nodes: int) -> np.ndarray:
        return element_keys(self.elements.reshape(-1, self.elements.shape[2]), nodes)

    def allocate(self, pattern: Pattern) -> None:
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
            self.formulation.modes,
            self.formulation.centre,
            self._compliance_inv,
            self.shear_modulus,
            self.pressure,
            self.modes,
            residual,
            matrix is not None,
            matrix.data if matrix is not None else _NO_DATA,
            self._slots,
            pattern.node_ptr,
            pattern.upper,
            self._b,
            self._excess,
            self._follow,
        )
        self._expanded = x.copy() if self.modes.size else None
        return True

    def increment(self, du: np.ndarray) -> None:
        hexahedra.mode_increment(du, self.elements, self._follow, self._change)
        hexahedra.pressure_increment(
            du, self.elements, self._change, self._compliance_inv, self._b, self._excess, self._dp
        )

    def advance(self, fraction: float) -> None:
        self.pressure += fraction * self._dp
        self.modes += fraction * self._change

    def merit(self, x: np.ndarray) -> float:
        modulus = MERIT_BULK_OVER_SHEAR * self.shear_modulus
        modes = self.modes
        if self._expanded is not None:
            hexahedra.mode_increment(x - self._expanded, self.elements, self._follow, self._trial)
            modes = modes + self._trial
        value, smallest = self._potential(x, self.pressure + self._dp, modes, modulus)
        return value if smallest > 0.0 else np.inf

    def energy(self, x: np.ndarray) -> float:
        value, _ = self._potential(x, self.pressure, self.modes, 0.0)
        return value - 0.5 * float(np.einsum("sei,eij,sej->", self.pressure, self._compliance, self.pressure))

    def history(self) -> Arrays:
        if self.modes.size == 0:
            return {"pressure": self.pressure.copy()}
        return {"pressure": self.pressure.copy(), "modes": self.modes.copy()}

    def load(self, history: Arrays) -> None:
        self.pressure[:] = history["pressure"]
        if self.modes.size:
            self.modes[:] = history["modes"]

    def _potential(self, x: np.ndarray, pressure: np.ndarray, modes: np.ndarray, modulus: float) -> tuple[float, float]:
        form = self.formulation
        return hexahedra.merit(
            x,
            modes,
            self.elements,
            form.grads,
            form.weights,
            form.psi,
            form.modes,
            form.centre,
            self.shear_modulus,
            pressure,
            modulus,
        )


_NO_DATA = np.zeros(0)
_NO_PATTERN = Pattern(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64), False)
