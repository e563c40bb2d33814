"""How far the force depends on numerical drag, speed, settling and the end of the mapping: one change at a time.

For each knot the table has the force at some displacements as the scene is, what each change makes of it, and where
the rods jump. In quasi-static steps none of these numbers means anything physical.

Run with: python benchmarks/quasi_static.py MODEL [KNOT] ...    with MODEL rod or fem
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from rod_common import table

import knotfem as kf
from knotfem.verify.benchmarks.wraps import pull

KNOTS: dict[str, tuple[float, ...]] = {
    "bowline": (9.0, 60.0, 99.0),
    "figure-eight": (10.0, 20.0, 40.0, 100.0),
    "clove-hitch": (10.0, 20.0, 40.0),
    "thin-overhand": (40.0, 80.0, 120.0),
}
"""Displacements at which forces are compared [mm]."""
SLIP, MOVE = "quasi_static.settling_slip_over_diameter", "quasi_static.settling_move_over_diameter"
CHANGES: dict[str, dict[str, Any]] = {
    "as it is": {},
    "drag may carry 0.1 x": {"quasi_static.tolerance": 0.00001},
    "drag may carry 10 x": {"quasi_static.tolerance": 0.001},
    "speed 0.25 x": {"speed": 0.25},
    "speed 4 x": {"speed": 4.0},
    "settling 0.2 x": {SLIP: 0.004, MOVE: 0.1},
    "settling 4 x": {SLIP: 0.08, MOVE: 2.0},
    "load steps 0.2 x": {"solver.move_over_diameter": 0.1},
    "curve smoothed": {"rods.0.smoothing.iterations": 100, "rods.0.smoothing.keep_size": True},
}
"""What is changed; `speed` is a factor on that of all pulls."""


def run_of(knot: str, model: str, changes: Mapping[str, Any]) -> kf.Run:
    """A knot pulled as its scene says, but for the changes."""
    changed = {"model": model, "output.fields": False, **changes}
    speed = changed.pop("speed", 1.0)
    if knot == "thin-overhand":
        return pull(1, **changed)[0]
    for i, step in enumerate(kf.load_scene(knot).steps):
        if step.kind == "pull":
            changed[f"steps.{i}.speed"] = f"{speed * step.nominal_speed} mm/s"
    return kf.pull(knot, changed, progress=False)


def main(model: str, knots: list[str]) -> None:
    """Print a table for each knot."""
    for knot in knots:
        rows, first = [], None
        for name, changes in CHANGES.items():
            run = run_of(knot, model, changes)
            force = run.force.at(np.array(KNOTS[knot]))
            first = force if first is None else first
            pulled = np.isin(run.events["step"], list(run.force.spans))
            jumps = ", ".join(f"{at:.1f}" for at in run.events["displacement_mm"][pulled])
            figures = [f"{f:.5g} ({f / g - 1.0:+.2%})" for f, g in zip(force, first, strict=True)]
            rows.append([name, *figures, jumps or "none", f"{run.cost.cpu_s:.0f}"])
            print(rows[-1], file=sys.stderr, flush=True)
        table(
            f"{knot}, {model}", ["change", *(f"F({at:g} mm), N" for at in KNOTS[knot]), "jumps at, mm", "CPU s"], rows
        )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or list(KNOTS))
