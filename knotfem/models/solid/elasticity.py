"""Nearly incompressible hyperelastic hexahedra in a mixed form, equivalent to C3D8H for the neo-Hookean law."""

from __future__ import annotations

import numpy as np

from knotfem.models.material import Material, check_material
from knotfem.models.solid import hexahedra
from knotfem.models.solid.formulation import Formulation
from knotfem.models.solid.incompatible import mode_increment
from knotfem.models.solid.potential import invariants, potential
from knotfem.models.solid.views import CondensedView, ElementView, LawView, PlacesView, UnknownsView
from knotfem.solver.term import Role, Term
from knotfem.sparse.pattern import Matrix, Pattern, stencil_keys, view_of
from knotfem.types import Arrays

MERIT_BULK_OVER_SHEAR = 20.0
"""Moderate bulk modulus over the shear modulus in the line search's merit; the true one allows no rotation."""

_NOWHERE = np.zeros((0, 0, 0))


class Elasticity(Term):
    """The bulk of one rod.

    W(I1) + p (J - 1) - p^2 / (2 kappa), the pressure p an unknown of each element. Incompatible modes, where the
    formulation has them, are unknowns of each element too; see `hexahedra`.

    Args:
        elements: connectivity, shape [slices, quads, n].
        formulation: tables of one layer.
        material: the law W.
        bulk_modulus: kappa [MPa].
        heights: lengths of the layers over that of the tables, shape [slices]; None for layers as long as these.

    Raises:
        InputError: a law that no solid has.

    Attributes:
        heights: of the layers.
        pressure: coefficients p_q [MPa], shape [slices, quads, q].
        modes: incompatible modes, shape [slices, quads, k, 3].
        smallest_j: smallest determinant of the deformation gradient, as last assembled.
    """

    name, role = "elasticity", Role.ELASTIC

    def __init__(
        self,
        elements: np.ndarray,
        formulation: Formulation,
        material: Material,
        bulk_modulus: float,
        heights: np.ndarray | None = None,
    ) -> None:
        check_material(material)
        self.elements, self.formulation = elements, formulation
        self.material, self.bulk_modulus = material, bulk_modulus
        slices, quads, count = elements.shape
        self.heights = np.ones(slices) if heights is None else heights
        psi, weights = formulation.psi, formulation.weights
        pressures, extra = psi.shape[2], formulation.modes.shape[2]
        self._compliance = np.einsum("epi,epj,ep->eij", psi, psi, weights) / bulk_modulus
        self._view = ElementView(
            np.ascontiguousarray(elements, dtype=np.int64),
            formulation.grads,
            weights,
            psi,
            formulation.modes,
            formulation.centre,
            np.linalg.inv(self._compliance),
            self.heights,
        )
        self._slots = np.empty((slices * quads, count, count), dtype=np.int32)
        self._condensed = CondensedView(
            np.zeros((slices, quads, pressures, 3 * (count + extra))),
            np.zeros((slices, quads, pressures)),
            np.zeros((slices, quads, 3 * extra, 3 * count + 1)),
        )
        self.pressure = np.zeros((slices, quads, pressures))
        self.modes = np.zeros((slices, quads, extra, 3))
        self._dp, self._change, self._trial = (np.zeros_like(a) for a in (self.pressure, self.modes, self.modes))
        self._expanded: np.ndarray | None = None
        self.smallest_j, self._pivot, self._law_holds = 1.0, np.inf, True

    @property
    def shear_modulus(self) -> float:
        """At small strain [MPa]."""
        return self.material.shear_modulus

    @property
    def layer_heights(self) -> np.ndarray:
        """Lengths of the hexahedra along the rod [mm], two over the axial gradient of their reference coordinate, shape
        [slices]."""
        count = self.elements.shape[2]
        levels = 2 if count == 8 else 3
        level = np.repeat(np.linspace(-1.0, 1.0, levels), count // levels)
        return self.heights * (2.0 / (self.formulation.grads[0, 0, :, 2] @ level))

    @property
    def weights(self) -> np.ndarray:
        """Reference volumes of the integration points [mm^3], shape [slices, quads, points]."""
        return self.heights[:, None, None] * self.formulation.weights

    @property
    def admissible(self) -> bool:
        return self.smallest_j > 0.0 and self._pivot > 0.0 and self._law_holds

    def describe(self) -> str:
        return f"{self.elements.shape[0] * self.elements.shape[1]} hexahedra, {self.material.describe()}"

    def deformation(self, x: np.ndarray) -> np.ndarray:
        """Deformation gradients at the integration points, shape [slices, quads, points, 3, 3]."""
        form, places = self.formulation, x[self.elements]
        F = np.einsum("sqai,qgak->sqgik", places, form.grads)
        tangents = np.einsum("am,sqai->sqmi", form.centre, places)
        F += np.einsum("qgm,sqmi,sqmk->sqgik", form.modes, tangents, self.modes)
        F[..., 2] /= self.heights[:, None, None, None]
        return F

    def nodal_forces(self, x: np.ndarray, stress: np.ndarray) -> np.ndarray:
        """Forces on the nodes of each hexahedron [N], shape [slices, quads, n, 3].

        Args:
            x: positions [mm], shape [nodes, 3].
            stress: first Piola-Kirchhoff stress times volume, shape [slices, quads, points, 3, 3].
        """
        form, stress = self.formulation, stress.copy()
        stress[..., 2] /= self.heights[:, None, None, None]
        direct = np.einsum("sqgik,qgak->sqai", stress, form.grads)
        turned = np.einsum("sqgik,qgm,sqmk->sqmi", stress, form.modes, self.modes)
        return direct + np.einsum("sqmi,am->sqai", turned, form.centre)

    def couplings(self, nodes: int) -> np.ndarray:
        return stencil_keys(self.elements.reshape(-1, self.elements.shape[2]), nodes)

    def allocate(self, pattern: Pattern) -> None:
        flat = self.elements.reshape(-1, self.elements.shape[2])
        hexahedra.element_slots(flat, pattern.node_ptr, pattern.node_adj, self._slots)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        law, unknowns = self._law(x), UnknownsView(self.pressure, self.modes)
        view = view_of(matrix, residual.shape[1])
        places = PlacesView(view.wanted, view.node_ptr, view.data, view.upper, self._slots)
        self.smallest_j, self._pivot = hexahedra.assemble(
            x, self._view, law, unknowns, self._condensed, residual, places
        )
        self._expanded = x.copy() if self.modes.size else None
        return True

    def increment(self, du: np.ndarray) -> None:
        mode_increment(du, self._view.nodes, self._condensed.follow, self._change)
        hexahedra.pressure_increment(du, self._view, self._change, self._condensed, self._dp)

    def advance(self, fraction: float) -> None:
        self.pressure += fraction * self._dp
        self.modes += fraction * self._change

    def merit(self, x: np.ndarray) -> float:
        modulus = MERIT_BULK_OVER_SHEAR * self.shear_modulus
        modes = self.modes
        if self._expanded is not None:
            mode_increment(x - self._expanded, self._view.nodes, self._condensed.follow, self._trial)
            modes = modes + self._trial
        value, smallest = self._potential(x, UnknownsView(self.pressure + self._dp, modes), modulus)
        return value if smallest > 0.0 and np.isfinite(value) else np.inf

    def energy(self, x: np.ndarray) -> float:
        value, _ = self._potential(x, UnknownsView(self.pressure, self.modes), 0.0)
        stored = np.einsum("s,sei,eij,sej->", self.heights, self.pressure, self._compliance, self.pressure)
        return value - 0.5 * float(stored)

    def history(self) -> Arrays:
        if self.modes.size == 0:
            return {"pressure": self.pressure.copy()}
        return {"pressure": self.pressure.copy(), "modes": self.modes.copy()}

    def load(self, history: Arrays) -> None:
        self.pressure[:] = history.get("pressure", 0.0)
        if self.modes.size:
            self.modes[:] = history.get("modes", 0.0)

    def _law(self, x: np.ndarray) -> LawView:
        """The law at the integration points; one number where it is linear."""
        if self.material.linear:
            return LawView(self.material.shear_modulus, _NOWHERE, _NOWHERE)
        invariant, _ = self._invariants(x, self.modes)
        with np.errstate(all="ignore"):
            first, second = (_values(f(invariant)) for f in (self.material.first, self.material.second))
        self._law_holds = bool(np.isfinite(first).all() and np.isfinite(second).all() and first.min() > 0.0)
        return LawView(self.material.shear_modulus, first, second)

    def _potential(self, x: np.ndarray, unknowns: UnknownsView, modulus: float) -> tuple[float, float]:
        """Potential [N mm] and smallest J, see `potential`."""
        if self.material.linear:
            return potential(x, self._view, unknowns, self.material.shear_modulus, modulus)
        invariant, determinant = self._invariants(x, unknowns.modes)
        weights, dilatation = self.weights, determinant - 1.0
        pressure = np.einsum("qgm,sqm->sqg", self.formulation.psi, unknowns.pressure)
        with np.errstate(all="ignore"):
            density = self.material.energy(invariant) + pressure * dilatation
        opening = np.einsum("sqg,sqg->sq", weights, dilatation)
        value = np.einsum("sqg,sqg->", weights, density) + 0.5 * modulus * np.sum(opening**2 / weights.sum(axis=2))
        return float(value), float(determinant.min())

    def _invariants(self, x: np.ndarray, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shape = (self.elements.shape[0], *self.formulation.weights.shape)
        invariant, determinant = np.empty(shape), np.empty(shape)
        invariants(x, self._view, modes, invariant, determinant)
        return invariant, determinant


def _values(values: np.ndarray) -> np.ndarray:
    """What a law returned, as compiled loops take it."""
    return np.ascontiguousarray(values, dtype=np.float64)
