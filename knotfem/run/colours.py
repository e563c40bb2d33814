"""What colours the pictures of a run, which are named after it."""

from __future__ import annotations

OLDER = {"pressure": "contact-pressure"}
"""Names that colours had; `pressure` is the name of another field, the mean stress."""
DIVERGING = "coolwarm"
"""Map of values of either sign, zero in its middle."""
TOUCHING = ("#dfe3e6", "#f7c56b", "#e2572b", "#7a0a2b")
"""Colours of values that are zero wherever nothing happens, from the lowest to the highest: zero is a light grey."""
COLOURS = {
    "strain": ("largest_principal_strain", "largest principal logarithmic strain", "viridis"),
    "tension": ("tension", "tension [N]", "plasma"),
    "contact-pressure": ("contact_pressure", "contact pressure [MPa]", TOUCHING),
    "curvature": ("curvature", "curvature [1/mm]", "viridis"),
    "twist": ("twist", "twist [rad/mm]", DIVERGING),
    "none": ("", "", "viridis"),
}
"""Field, its name with unit, and the map of its values, by the colour that is asked for."""
