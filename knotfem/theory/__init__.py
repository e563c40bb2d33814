"""Closed forms of knots in elastic rods: capstan, bowline, loose open knots, braids.

`capstan` has the tension in a rope that slips on a cylinder. `bowline` and `stability` have the model of Aymon,
Derveni, Gomez, Crassous and Reis, Extreme Mech. Lett. 81, 102413 (2025), "the paper" in this package: the force at
which the central rods slip, and the friction above which the knot holds. `fits` finds the two parameters of that model
from measurements. `loose` has knots whose loop is much larger than the rod.

All functions act on numbers and on arrays that broadcast; numbers give numbers. Of the project, this package imports
`errors` and `types` only.
"""

from knotfem.theory.bowline import (
    PAPER,
    Parameters,
    crossing,
    flexible_holding_force,
    holding_force,
    stiff_holding_force,
)
from knotfem.theory.capstan import capstan_exponent, capstan_friction, tension_profile, tension_ratio
from knotfem.theory.fits import Fit, fit_boundary, fit_holding_force
from knotfem.theory.loose import braid_force, braid_wave_number, loose_knot_contact_force, loose_knot_force
from knotfem.theory.stability import (
    central_rods_friction,
    critical_friction,
    critical_stiffness,
    failure_mode,
    holds,
    stiff_friction,
    stiff_friction_error,
    wrapping_rod_friction,
)

__all__ = [
    "PAPER", "Fit", "Parameters", "braid_force", "braid_wave_number", "capstan_exponent", "capstan_friction",
    "central_rods_friction", "critical_friction", "critical_stiffness", "crossing", "failure_mode", "fit_boundary",
    "fit_holding_force", "flexible_holding_force", "holding_force", "holds", "loose_knot_contact_force",
    "loose_knot_force", "stiff_friction", "stiff_friction_error", "stiff_holding_force", "tension_profile",
    "tension_ratio", "wrapping_rod_friction",
]  # fmt: skip
