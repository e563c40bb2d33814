"""What the columns of a run's tables are; their names end with the unit."""

from __future__ import annotations

from knotfem.models.contacts import CONTACT_COLUMNS
from knotfem.run.columns import (
    DRAWN_IN,
    EVENT_COLUMNS,
    FORCE_COLUMNS,
    FORCE_EXTRA,
    OF_STATE,
    TENSION_COLUMNS,
    TENSION_EXTRA,
    TIE_COLUMNS,
    TWIST_COLUMNS,
)

TABLES = {
    "tie": TIE_COLUMNS,
    "force": (*FORCE_COLUMNS, *FORCE_EXTRA, "numerical_drag_Nmm", DRAWN_IN),
    "tension": (*TENSION_COLUMNS, *TENSION_EXTRA),
    "contacts": (*CONTACT_COLUMNS, *OF_STATE),
    "twist": TWIST_COLUMNS,
    "events": EVENT_COLUMNS,
}
"""Columns by table; force.csv has one more, NAME_Nmm, for each further term."""
ROWS = {
    "tie": "an increment of the mapping",
    "force": "an accepted step after tying (the mapping and the relaxing steps at the head in which no end is loaded)",
    "tension": "a cross-section of a rod in a stored state",
    "contacts": "a contact sample that carries force in a stored state",
    "twist": "a node of a discrete rod in a stored state",
    "events": "a jump from one branch of equilibria to another",
}
"""What a row is, by table."""
COLUMNS = {
    "time_s": "simulated time; in quasi-static steps it says how far loads are",
    "displacement_mm": "displacement of the reported end along its direction, over all steps after tying",
    "step_displacement_mm": "the same since the scene's step began",
    "step": "name of the scene's step",
    "wall_s": "wall time that it took",
    "newton_iterations": "iterations of Newton's method in the accepted attempt",
    "mapping_time": "progress of the mapping, from 0 to 1",
    "max_stretch": "largest stretch of the centreline",
    "min_stretch": "smallest stretch of the centreline",
    "force_N": "force at the reported end along its direction",
    "contacts": "contact samples that carry force",
    "sliding": "those of them that slide",
    "max_penetration_mm": "deepest overlap of surfaces",
    "kinetic_over_internal": "kinetic over elastic energy",
    "imbalance_N": "size of the sum of all external forces, without drag and inertia",
    "drag_force_N": "size of the sum of all viscous forces",
    "unrest_N": "dynamic residual: largest sum of drag and inertia forces from the start of a rod up to any section",
    "work_Nmm": "work of supports, clamps and loads since the balance of energy began",
    "elastic_Nmm": "elastic energy stored in the rods",
    "kinetic_Nmm": "kinetic energy",
    "contact_Nmm": "energy stored in the contact penalty",
    "gravity_Nmm": "energy of the weight",
    "friction_Nmm": "energy dissipated by sliding so far",
    "drag_Nmm": "energy dissipated by the drag of the scene in real time so far",
    "numerical_drag_Nmm": "energy dissipated by numerical drag in quasi-static steps so far",
    "numerical_Nmm": "algorithmic dissipation: what the time integration has dissipated so far",
    "missing_Nmm": "energy balance error: work that is neither stored nor dissipated",
    "cutbacks": "attempts at the step that were rejected",
    "equilibrium": "1 where the step ended in equilibrium, else 0",
    "drawn_in_mm": "length of the free end that has been drawn in furthest; where a scene shows whether its knot holds",
    "arclength_mm": "arclength from the start of the rod",
    "s_over_L": "arclength over the length of the rod",
    "tension_N": "axial force: sum of nodal forces across the section",
    "core_N": "axial force of the core, from its stress",
    "bulk_N": "axial force of the bulk, from the integral of its stress",
    "rod": "name of the rod",
    "shear_N": "shear force",
    "bending_moment_Nmm": "bending moment",
    "torque_Nmm": "twisting moment",
    "x_mm": "place of the section's centre, x",
    "y_mm": "place of the section's centre, y",
    "z_mm": "place of the section's centre, z",
    "twist_rad_per_mm": "twist, angle per arclength",
    "curvature_per_mm": "curvature of the centreline",
    "other": "name of the rod or obstacle that is touched",
    "other_arclength_mm": "arclength there, on a rod",
    "gap_mm": "distance of the surfaces, negative where they overlap",
    "normal_force_N": "normal force of the sample",
    "friction_force_N": "friction force of the sample",
    "state": '"sticks" or "slips"',
    "force_before_N": "force at the reported end in the last equilibrium before the jump; nan without one in the step",
    "force_after_N": "force at the reported end in the first equilibrium after it",
    "moved_mm": "how far the place moved that moved furthest",
    "released_Nmm": "energy that numerical drag took on the way",
    "steps": "time steps on the way",
}
"""What a column is, by name."""
SUFFIXES = {
    "rad_per_mm": "rad/mm", "per_mm": "1/mm", "Nmm": "N mm", "mm": "mm", "N": "N", "s": "s",
}  # fmt: skip


def unit_of_column(name: str) -> str:
    """Unit at the end of a column's name; "" where it has none."""
    return next((unit for suffix, unit in SUFFIXES.items() if name.endswith(f"_{suffix}")), "")
