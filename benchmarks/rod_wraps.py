"""Overhand knots of one to four wraps in a thin soft rod, held against an independent program, and where they snap.

Knots, figures and what is fitted: `knotfem.verify.benchmarks.wraps`. The first two are checked by
`knotfem verify --only wraps`.

Run with: python benchmarks/rod_wraps.py [1] [2] [3] [4]
"""

from __future__ import annotations

import sys

import numpy as np
from rod_common import table

from knotfem.verify.benchmarks.wraps import KNOTS, LENGTH, beside, pull


def main(wraps: list[int]) -> None:
    """Pull the knots and print what came out."""
    for number in wraps:
        knot = KNOTS[number]
        run, drawn = pull(number)
        if knot.at:
            zero, found = beside(knot, run, drawn)
            title = f"{number} wraps, zero at an end distance of {zero:.0f} mm"
            rows = [
                [f"{at:g}", f"{theirs:g}", f"{ours:.3f}", f"{ours / theirs - 1:+.1%}"]
                for at, theirs, ours in zip(knot.at, knot.force, found, strict=True)
            ]
            table(title, ["displacement, mm", "theirs, mN", "ours, mN", "difference"], rows)
        events = run.events
        for row in np.flatnonzero(events["step"] == "pull"):
            at = (drawn + 2.0 * events["displacement_mm"][row]) / LENGTH
            before, after = (1e3 * events[f"force_{when}_N"][row] for when in ("before", "after"))
            print(f"{number} wraps: snap at {at:.3f} L, {before:.1f} to {after:.1f} mN (published: {knot.snap or '-'})")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or list(KNOTS))
