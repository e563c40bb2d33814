"""What the fields of results.vtkhdf are, and their units."""

from __future__ import annotations

from dataclasses import dataclass

TENSOR = "xx, yy, zz, xy, yz, xz"
"""Order of the components of symmetric tensors, as ParaView has it."""
MORE = "points; fem: cells too"


@dataclass(frozen=True)
class Meaning:
    """What a field is.

    Attributes:
        text: in words.
        unit: "1" without dimension.
        components: in their order, "" of scalars.
        models: that have it.
        places: "points", "cells" or both.
    """

    text: str
    unit: str
    components: str = ""
    models: str = "fem, rod"
    places: str = "points"


FIELDS = {
    "displacement": Meaning("displacement from the straight, untied rods", "mm", "x, y, z"),
    "arclength": Meaning("arclength along the rod that the point is on", "mm"),
    "rod": Meaning("number of the rod, from 0 in the order of the scene", "1"),
    "tension": Meaning("axial force of the cross-section, core and bulk together", "N", places=MORE),
    "contact_pressure": Meaning("pressure of contacts on the surface", "MPa"),
    "largest_principal_strain": Meaning(
        "largest principal logarithmic strain; on cells of its mean deformation", "1", places=MORE
    ),
    "stress": Meaning("Cauchy stress; on cells the mean", "MPa", TENSOR, "fem", "points, cells"),
    "pressure": Meaning(
        "mean stress with a minus, -tr(stress)/3; not that of contacts", "MPa", models="fem", places="points, cells"
    ),
    "curvature": Meaning("curvature of the centreline", "1/mm", models="rod"),
    "twist": Meaning("twist, angle per arclength", "rad/mm", models="rod"),
    "displacement_mm": Meaning(
        "displacement of the reported end over all steps after tying, one value a step", "mm", places="field data"
    ),
}
"""By name."""
