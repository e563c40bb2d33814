"""Hyperelastic laws of nearly incompressible solids: energies of the isochoric first invariant.

The energy per reference volume is W(I1) + p (J - 1) - p^2 / (2 kappa), with I1 = J^(-2/3) tr C, which is 3 without
strain, and the pressure p an unknown of its own (`hexahedra`). The deviatoric Kirchhoff stress and its tangent follow
from two derivatives alone: with b' = J^(-2/3) F F^T,

    tau = 2 W' dev(b')        c = c_neo-Hooke(mu = 2 W') + 4 W'' dev(b') x dev(b')

A law of the user's own is a subclass of `Material`:

    class Yeoh(Material):
        def __init__(self, c1, c2, c3):
            self.c1, self.c2, self.c3 = c1, c2, c3

        def energy(self, invariant):
            e = invariant - 3.0
            return self.c1 * e + self.c2 * e**2 + self.c3 * e**3

        def first(self, invariant):
            e = invariant - 3.0
            return self.c1 + 2.0 * self.c2 * e + 3.0 * self.c3 * e**2

        def second(self, invariant):
            return 2.0 * self.c2 + 6.0 * self.c3 * (invariant - 3.0)
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from knotfem.errors import InputError

_PROBES = np.array([3.001, 3.01, 3.1])
_STEP = 1e-4
_AGREEMENT = 1e-4


class Material(ABC):
    """An isochoric hyperelastic law W(I1).

    The functions take and return arrays of one shape, a value for each integration point. Where a law ends, as
    Gent's does at its limiting stretch, they return infinity or nan: the solver takes shorter steps then.

    Attributes:
        linear: whether W is linear in I1, so that 2 W' is the shear modulus everywhere: such a law is computed in
            compiled code alone.
    """

    linear: bool = False

    @abstractmethod
    def energy(self, invariant: np.ndarray) -> np.ndarray:
        """W(I1) per reference volume [MPa], 0 at I1 = 3."""

    @abstractmethod
    def first(self, invariant: np.ndarray) -> np.ndarray:
        """dW/dI1 [MPa], positive."""

    @abstractmethod
    def second(self, invariant: np.ndarray) -> np.ndarray:
        """d2W/dI1^2 [MPa]."""

    @property
    def shear_modulus(self) -> float:
        """Shear modulus at small strain, 2 W'(3) [MPa]."""
        return 2.0 * float(self.first(np.array([3.0]))[0])

    def describe(self) -> str:
        """The law and its main figure, for a reader."""
        return f"{type(self).__name__}, G {self.shear_modulus:.4g} MPa"


class NeoHooke(Material):
    """W = mu/2 (I1 - 3).

    Args:
        shear_modulus: mu [MPa].
    """

    linear = True

    def __init__(self, shear_modulus: float) -> None:
        self._mu = float(shear_modulus)

    @property
    def shear_modulus(self) -> float:
        """mu [MPa]."""
        return self._mu

    def energy(self, invariant: np.ndarray) -> np.ndarray:
        return 0.5 * self._mu * (invariant - 3.0)

    def first(self, invariant: np.ndarray) -> np.ndarray:
        return np.full_like(invariant, 0.5 * self._mu)

    def second(self, invariant: np.ndarray) -> np.ndarray:
        return np.zeros_like(invariant)

    def describe(self) -> str:
        return f"G {self._mu:.4g} MPa"


def check_material(material: Material) -> None:
    """Refuse a law that no solid has, or whose derivatives are not those of its energy.

    Args:
        material: a law.

    Raises:
        InputError: what is wrong.
    """
    name = type(material).__name__
    modulus = material.shear_modulus
    if not (np.isfinite(modulus) and modulus > 0.0):
        raise InputError(
            "the shear modulus of a material is positive",
            key=name,
            found=f"2 W'(3) = {modulus:g}",
            expected="more than 0",
        )
    at_rest = material.energy(np.array([3.0]))
    if np.shape(at_rest) != (1,):
        raise InputError(
            "the functions of a material return an array", key=name, found=f"shape {np.shape(at_rest)}", expected="(1,)"
        )
    if abs(float(at_rest[0])) > _AGREEMENT * modulus:
        raise InputError("energy is stored without strain", key=name, found=f"W(3) = {at_rest[0]:g}", expected="0")
    with np.errstate(all="ignore"):
        for what, function, rate in (
            ("first", material.energy, material.first),
            ("second", material.first, material.second),
        ):
            slope = (function(_PROBES + _STEP) - function(_PROBES - _STEP)) / (2.0 * _STEP)
            error = np.abs(rate(_PROBES) - slope) / np.maximum(modulus, np.abs(slope))
            if (worst := float(np.nanmax(error, initial=0.0))) > _AGREEMENT:
                integral = "energy" if what == "first" else "first"
                raise InputError(
                    f"{what}(I1) is not the derivative of {integral}(I1)",
                    key=name,
                    found=f"a relative deviation of {worst:.2g} at I1 = {_PROBES[np.nanargmax(error)]:g}",
                )
