"""All closed-form cases, in the order of the tables of docs/validation.md."""

from __future__ import annotations

from knotfem.verify.verdict import Case


def closed_forms() -> list[Case]:
    """The suite of `knotfem verify`."""
    from knotfem.verify import bending, oscillator, slope, small_motions, solids

    return [*bending.CASES, *solids.CASES, *small_motions.CASES, *oscillator.CASES, *slope.CASES]
