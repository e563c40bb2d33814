"""Overhand knots of one to four wraps in a thin soft rod, held against an independent program, and where they snap.

The other program is one of discrete rods with contact as a constraint; its figures are means over 1.7 mm either way
(L = 1 m, d = 3.2 mm, E = 1.8 MPa, nu = 0.5, mu = 0.1, no weight, both ends driven apart). Where it begins to count is
not known: the end distance of its zero is fitted, one number for each knot.

Run with: python benchmarks/rod_wraps.py [1] [2] [3] [4]
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rod_common import table
from rod_overhand import torus_knot

import knotfem as kf

LENGTH, RADIUS = 1000.0, 1.6


@dataclass(frozen=True)
class Wraps:
    """A knot and what is known of it.

    Attributes:
        turns: by which its end is turned when it is tied.
        loop: radius of the loop that is drawn [mm].
        segments: of the rod.
        furthest: end distance to which it is pulled [mm].
        at: displacements of the other program [mm].
        force: its forces there [mN].
        snap: published end distance over L at which the loop changes sides.
    """

    turns: float
    loop: float
    segments: int
    furthest: float
    at: tuple[float, ...] = ()
    force: tuple[float, ...] = ()
    snap: str = ""


KNOTS = {
    1: Wraps(1.011, 120.0, 250, 600.0, (10, 25, 40, 55, 70, 85, 98), (1.020, 1.002, 1.104, 1.199, 1.227, 1.261, 1.298)),
    2: Wraps(1.042, 100.0, 250, 780.0, (20, 60, 100, 180, 260, 340, 420), (5.42, 5.97, 7.70, 9.96, 14.6, 24.0, 42.0)),
    3: Wraps(0.0, 90.0, 250, 860.0, snap="0.78"),
    4: Wraps(0.0, 60.0, 300, 760.0, snap="0.65 to 0.68"),
}


def pull(wraps: int, folder: Path, **changes: object) -> tuple[kf.Run, float]:
    """A knot pulled to its end distance, and the end distance from which it was [mm]."""
    knot = KNOTS[wraps]
    points = torus_knot(wraps, RADIUS, knot.loop, knot.segments, LENGTH)
    path = folder / f"{wraps}.csv"
    np.savetxt(path, points, delimiter=",", header="x,y,z", comments="")
    drawn = float(np.linalg.norm(points[-1] - points[0]))
    ends = {side: {"motion": "driven", "direction": [sign, 0, 0]} for side, sign in (("start", -1), ("end", 1))}
    scene = {
        "name": f"{wraps}-wraps",
        "model": "rod",
        "rods.0.centerline": str(path),
        "rods.0.length": f"{LENGTH} mm",
        "rods.0.diameter": f"{2 * RADIUS} mm",
        "rods.0.twist": f"{knot.turns} turns",
        "rods.0.core": None,
        "rods.0.material.youngs_modulus": "1.8 MPa",
        "rods.0.mesh.element_length": f"{LENGTH / knot.segments} mm",
        "contact.friction": 0.1,
        "solver.force_tolerance": "1e-8 N",
        "output.fields": False,
        "output.every_displacement": "5 mm",
        "steps": [
            {"kind": "relax"},
            {"kind": "pull", "displacement": f"{0.5 * (knot.furthest - drawn)} mm", "ends": {"rod": ends}},
        ],
        **changes,
    }
    return kf.pull("overhand", scene), drawn


def zero_of(knot: Wraps, distance: np.ndarray, force: np.ndarray) -> float:
    """End distance at which the other program counts 0, such that its forces are met best [mm]."""
    zeros = np.arange(distance[0], distance[-1] - knot.at[-1], 1.0)
    misfit = [np.sum(np.log(np.interp(zero + np.array(knot.at), distance, force) / knot.force) ** 2) for zero in zeros]
    return float(zeros[int(np.argmin(misfit))])


def main(wraps: list[int]) -> None:
    """Pull the knots and print what came out."""
    for number in wraps:
        knot = KNOTS[number]
        with tempfile.TemporaryDirectory() as folder:
            run, drawn = pull(number, Path(folder))
        distance, force = drawn + 2.0 * run.force.displacement, 1e3 * run.force.force
        if knot.at:
            zero = zero_of(knot, distance, force)
            found = np.interp(zero + np.array(knot.at), distance, force)
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
