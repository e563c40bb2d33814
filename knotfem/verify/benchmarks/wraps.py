"""Overhand knots of one and more wraps in a thin soft rod, held against an independent program.

The other program is one of discrete rods with contact as a constraint; its figures are means over 1.7 mm either way and
scatter by 2 to 6 % (L = 1 m, d = 3.2 mm, E = 1.8 MPa, nu = 0.5, mu = 0.1, no weight, both ends driven apart). Where it
begins to count is not known: the end distance of its zero is fitted, one number for each knot. The knot must therefore
be drawn so loose that its pull begins before that.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from knotfem.api import pull as pull_scene
from knotfem.geometry.curve import interpolate
from knotfem.geometry.resample import equal_chords
from knotfem.results.run import Run
from knotfem.verify.case import Case, Quantity

LENGTH, RADIUS = 1000.0, 1.6
CLOSE_FROM = 40.0
"""From this displacement on [mm] both programs must agree; before, the knot depends on how it was drawn."""


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
    2: Wraps(1.042, 115.0, 250, 780.0, (20, 60, 100, 180, 260, 340, 420), (5.42, 5.97, 7.70, 9.96, 14.6, 24.0, 42.0)),
    3: Wraps(0.0, 90.0, 250, 860.0, snap="0.78"),
    4: Wraps(0.0, 60.0, 300, 760.0, snap="0.65 to 0.68"),
}
"""By the number of wraps."""


def torus_knot(n: int, radius: float, loop: float, segments: int, length: float) -> np.ndarray:
    """Nodes of an open (2, 2n + 1) torus knot along x, shape (segments + 1, 3).

    It has 2n + 1 half turns of two strands, a loop, and straight tails.

    Args:
        n: number of wraps.
        radius: of the rod [mm].
        loop: radius of the loop [mm].
        segments: equal chords.
        length: of the rod [mm].
    """
    offset, turns = 1.3 * radius, 2 * n + 1
    half = 0.8 * turns * np.sqrt(radius * loop)
    s = np.linspace(-1.0, 1.0, 40 * turns)
    angle = 0.5 * np.pi * (turns * (1.0 + s) - 1.0)
    first = np.stack([half * s, offset * np.sin(angle), offset * np.cos(angle)], axis=1)
    second = first * [1.0, -1.0, -1.0]
    size = max(loop, 1.5 * half)
    phi = np.linspace(0.0, 2.0 * np.pi, 60) - 0.5 * np.pi
    circle = np.stack([size * np.cos(phi), size * (1.0 + np.sin(phi)) + offset, 0.0 * phi], axis=1)
    circle = circle[np.hypot(circle[:, 0], circle[:, 1] - offset) > 1.2 * half]
    tail = np.stack([np.linspace(-0.5 * length, -1.3 * half, 30), np.full(30, -offset), np.zeros(30)], axis=1)
    curve = interpolate(np.concatenate([tail, first, circle, second, tail[::-1] * [-1.0, 1.0, 1.0]]))
    fine = equal_chords(curve, 8 * segments).points
    spare = int(0.5 * (len(fine) - 1 - length / np.linalg.norm(fine[1] - fine[0])))
    return equal_chords(interpolate(fine[spare : len(fine) - spare]), segments, length).points


def pull(wraps: int, **changes: Any) -> tuple[Run, float]:
    """A knot pulled to its end distance, and the end distance from which it was [mm].

    Args:
        wraps: a key of `KNOTS`.
        changes: keys of the scene.
    """
    knot = KNOTS[wraps]
    points = torus_knot(wraps, RADIUS, knot.loop, knot.segments, LENGTH)
    drawn = float(np.linalg.norm(points[-1] - points[0]))
    ends = {side: {"motion": "driven", "direction": [sign, 0, 0]} for side, sign in (("start", -1), ("end", 1))}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{wraps}.csv"
        np.savetxt(path, points, delimiter=",", header="x,y,z", comments="")
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
        return pull_scene("overhand", scene, progress=False), drawn


def beside(knot: Wraps, run: Run, drawn: float) -> tuple[float, np.ndarray]:
    """Forces where the other program has them.

    Args:
        knot: with forces of the other program.
        run: the knot pulled.
        drawn: end distance from which it was [mm].

    Returns:
        The end distance at which the other program counts 0, such that its forces are met best [mm], and the forces at
        its displacements [mN].
    """
    distance, force = drawn + 2.0 * run.force.displacement, 1e3 * run.force.force
    zero = _zero_of(knot, distance, force)
    return zero, np.interp(zero + np.array(knot.at), distance, force)


def _zero_of(knot: Wraps, distance: np.ndarray, force: np.ndarray) -> float:
    zeros = np.arange(distance[0], distance[-1] - knot.at[-1], 1.0)
    misfit = [np.sum(np.log(np.interp(zero + np.array(knot.at), distance, force) / knot.force) ** 2) for zero in zeros]
    return float(zeros[int(np.argmin(misfit))])


def compared(wraps: int) -> Sequence[Quantity]:
    """Forces of a knot against those of the other program.

    Args:
        wraps: 1 or 2.
    """
    knot = KNOTS[wraps]
    _, found = beside(knot, *pull(wraps))
    return [
        Quantity("F [mN]", ours, theirs, 0.06, condition=f"{at:g} mm")
        for at, theirs, ours in zip(knot.at, knot.force, found.tolist(), strict=True)
        if at >= CLOSE_FROM
    ]


CASES = [
    Case(
        "wraps",
        partial(compared, number),
        f"overhand knot of {number} wrap{'s'[: number > 1]} in a thin soft rod",
        "another program of discrete rods",
        f"{KNOTS[number].segments} discrete segments",
        str(number),
        slow=True,
    )
    for number in (1, 2)
]
