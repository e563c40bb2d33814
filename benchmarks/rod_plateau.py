"""Tension of the bowline's rods between the knot and a frictionless cylinder, under a dead load.

It follows from balance alone: 0.475 T0 where the small load on the free end points down, 0.525 T0 where it points up.

Run with: python benchmarks/rod_plateau.py
"""

from __future__ import annotations

import numpy as np
from rod_common import table

import knotfem as kf
from knotfem.study.dead_load import dead_load

SCENE = {"model": "rod", "contact.friction": 0.37, "obstacles.0.friction": 0.0, "output.fields": False}
X = 5.0
"""B/(T0 r^2)."""


def plateau(direction: float) -> float:
    """Median tension of the two legs between the knot and the cylinder, over T0."""
    base = kf.load_scene("bowline", SCENE)
    load = base.force_scale / X
    run = kf.pull(dead_load(base, load, free={"rod.end": (0.0, 0.0, direction)}), progress=False)
    profile, c = run.tension(), run.contacts()
    s, on_peg = profile.arclength, c["other"] != "rod"
    peg, knot = c["arclength_mm"][on_peg], c["arclength_mm"][~on_peg]
    up = (s > knot[knot < peg.min()].max()) & (s < peg.min())
    down = (s > peg.max()) & (s < knot[knot > peg.max()].min())
    return float(np.median(profile.tension[up | down])) / load


def main() -> None:
    """Print the table."""
    rows = []
    for direction, expected in ((-1.0, 0.475), (1.0, 0.525)):
        found = plateau(direction)
        rows.append((direction, found, expected, found / expected - 1.0))
    table(f"tension plateau over T0, x = {X:g}, no gravity", ("free end", "plateau", "expected", "deviation"), rows)


if __name__ == "__main__":
    main()
