"""Columns of the tables of a run; names carry units."""

from __future__ import annotations

import numpy as np

Value = float | int | str | np.generic
"""A cell of a table."""
TIE_COLUMNS = ("mapping_time", "max_stretch", "min_stretch", "newton_iterations", "wall_s")
FORCE_COLUMNS = (
    "time_s", "displacement_mm", "force_N", "newton_iterations", "contacts", "max_penetration_mm",
    "kinetic_over_internal", "wall_s",
)  # fmt: skip
FORCE_EXTRA = (
    "step", "sliding", "imbalance_N", "drag_force_N", "unrest_N", "work_Nmm", "elastic_Nmm", "kinetic_Nmm",
    "contact_Nmm", "gravity_Nmm", "friction_Nmm", "drag_Nmm", "numerical_Nmm", "missing_Nmm", "cutbacks",
    "equilibrium", "step_displacement_mm",
)  # fmt: skip
RUNNING = "step_displacement_mm"
"""Tables that have it have a displacement that runs on through the steps; older ones start again at each step."""
OF_STATE = ("step", RUNNING)
"""Further columns of all tables of stored states."""
DRAWN_IN = "drawn_in_mm"
"""Further column of force.csv where a scene shows whether its knot holds."""
TENSION_COLUMNS = ("displacement_mm", "arclength_mm", "s_over_L", "tension_N", "core_N", "bulk_N")
TENSION_EXTRA = ("rod", "time_s", "shear_N", "bending_moment_Nmm", "torque_Nmm", "x_mm", "y_mm", "z_mm", *OF_STATE)
EVENT_COLUMNS = (
    "step", "time_s", "displacement_mm", "force_before_N", "force_after_N", "rod", "s_over_L", "moved_mm",
    "released_Nmm", "steps", RUNNING,
)  # fmt: skip
TWIST_COLUMNS = (
    "displacement_mm", "arclength_mm", "s_over_L", "twist_rad_per_mm", "torque_Nmm", "curvature_per_mm",
    "bending_moment_Nmm", "rod", "time_s", *OF_STATE,
)  # fmt: skip
TEXT_COLUMNS = frozenset({"step", "rod", "other", "state"})
"""Columns of names, which stay text also where they look like numbers."""


def energy_column(name: str) -> str:
    """Column of the energy of a term of its own name."""
    return f"{name.replace(' ', '_')}_Nmm"
