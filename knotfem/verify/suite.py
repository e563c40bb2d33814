"""All cases with closed forms, in the order of the tables of docs/validation.md."""

from __future__ import annotations

from knotfem.verify.case import Case


def closed_forms() -> list[Case]:
    """The cases of `knotfem verify`."""
    from knotfem.verify.benchmarks import (
        bending,
        capstan,
        contact_patch,
        hertz,
        oscillator,
        overhand,
        slope,
        small_motions,
        solids,
        wraps,
    )

    rods = [*bending.CASES, *solids.CASES, *small_motions.CASES, *oscillator.CASES]
    return [*rods, *hertz.CASES, *contact_patch.CASES, *slope.CASES, *capstan.CASES, *overhand.CASES, *wraps.CASES]
