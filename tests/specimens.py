"""What the tests of effects, solver and section share with the cases of `knotfem verify`."""

from knotfem.verify.benchmarks.rods import (
    DENSITY,
    WHOLE_STEPS,
    Rod,
    beam_clamp,
    bent_into_arc,
    make_rod,
    march,
    moduli,
    static,
    surfaces,
)

__all__ = [
    "DENSITY",
    "WHOLE_STEPS",
    "Rod",
    "beam_clamp",
    "bent_into_arc",
    "make_rod",
    "march",
    "moduli",
    "static",
    "surfaces",
]
