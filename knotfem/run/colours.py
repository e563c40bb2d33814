"""What colours the pictures of a run, which are named after it."""

from __future__ import annotations

OLDER = {"pressure": "contact-pressure"}
"""Names that colours had; `pressure` is the name of another field, the mean stress."""
DIVERGING = "coolwarm"
"""Map of values of either sign, zero in its middle."""
COLOURS = {
    "strain": ("largest_principal_strain", "largest principal strain (logarithmic)", "viridis"),
    "tension": ("tension", "tension [N]", "plasma"),
    "contact-pressure": ("contact_pressure", "contact pressure [MPa]", "inferno"),
    "curvature": ("curvature", "curvature [1/mm]", "viridis"),
    "twist": ("twist", "twist [rad/mm]", DIVERGING),
    "none": ("", "", "viridis"),
}
"""Field, its name with unit, and the map of its values, by the colour that is asked for."""
