"""What the tests of terms, contact, solver and resultants share with the cases of `knotfem verify`."""

from knotfem.verify.benchmarks.rods import (
    DENSITY,
    WHOLE_STEPS,
    Rod,
    accepted_steps,
    at_rest,
    beam_clamp,
    bent_into_arc,
    cross_sections,
    final_state,
    make_core,
    make_rod,
    moduli,
    static,
    surfaces,
)

__all__ = [
    "DENSITY",
    "WHOLE_STEPS",
    "Rod",
    "accepted_steps",
    "at_rest",
    "beam_clamp",
    "bent_into_arc",
    "cross_sections",
    "final_state",
    "make_core",
    "make_rod",
    "moduli",
    "static",
    "surfaces",
]
