"""Stiffness and mass per length of a full circular section."""

from __future__ import annotations

import math


def axial_stiffness(youngs_modulus: float, radius: float) -> float:
    """EA [N], of E in MPa and the radius in mm."""
    return youngs_modulus * math.pi * radius**2


def bending_stiffness(youngs_modulus: float, radius: float) -> float:
    """B = EI [N mm^2], of E in MPa and the radius in mm."""
    return youngs_modulus * math.pi * radius**4 / 4.0


def twisting_stiffness(shear_modulus: float, radius: float) -> float:
    """C = GJ [N mm^2], of G in MPa and the radius in mm."""
    return shear_modulus * math.pi * radius**4 / 2.0


def mass_per_length(density: float, radius: float) -> float:
    """rho A [tonne/mm], of the density in tonne/mm^3 and the radius in mm."""
    return density * math.pi * radius**2
