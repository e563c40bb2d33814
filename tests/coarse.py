"""Changes of scenes that make runs of discrete rods short."""

from typing import Any

KNOT: dict[str, Any] = {
    "model": "rod",
    "rods.rod.length": "400 mm",
    "rods.rod.mesh.element_length": "6 mm",
    "contact.sample_spacing_over_diameter": 0.25,
    "tie.path": "direct",
    "solver.threads": 1,
    "steps.pull.displacement": "3 mm",
    "output.every_displacement": "1.5 mm",
}
"""Of the scene "overhand": a coarse knot that is pulled a little."""
HITCH: dict[str, Any] = {
    "model": "rod",
    "rods.0.mesh.element_length": "4 mm",
    "contact.sample_spacing_over_diameter": 0.25,
    "output.fields": False,
    "solver.threads": 1,
}
"""Of scenes with one rod."""
