"""Knots of rods in words, from the records that name them."""

from __future__ import annotations

from typing import Any

Knots = dict[str, dict[str, Any]]
"""Fields of `knotfem.run.monitor.RodKnot` of each rod, by its name, fit for JSON."""


def in_words(knots: Knots) -> dict[str, str]:
    """What each rod is tied into and linked with, in words, by its name."""
    said = {}
    for rod, knot in knots.items():
        linked = [other for other, polynomials in knot.get("laced", {}).items() if polynomials]
        said[rod] = knot["said"] + (f", linked with {' and '.join(linked)}" if linked else "")
    return said


def for_summary(knots: Knots | None) -> str | Knots | None:
    """What summary.json says of the knots of a run: of one rod the words, of several a record each."""
    return next(iter(in_words(knots).values())) if knots and len(knots) == 1 else knots


def knot_said(found: str | Knots | None) -> str | dict[str, str] | None:
    """What summary.json says of the knots of a run, in words; of several rods by their names."""
    return in_words(found) if isinstance(found, dict) else found


def knot_said_in_one(found: str | Knots | None) -> str | None:
    """What summary.json says of the knots of a run, as one text."""
    said = knot_said(found)
    return "; ".join(f"{rod}: {words}" for rod, words in said.items()) if isinstance(said, dict) else said
