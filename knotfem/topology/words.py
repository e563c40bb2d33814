"""Sentences on knots that are no longer what they were."""

from __future__ import annotations


def come_undone(knot: str, rod: str) -> str:
    """The knot of a rod, or the hitch, has come undone."""
    return f"the {knot} of {rod} has come undone"
