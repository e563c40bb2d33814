"""The bowline with 300 segments: from the scene to rest, and pulled by 99 mm at 4 mm/s, with wall seconds.

Given runs in 3D, each with its friction and its rate of drag, it prints the forces side by side.

Run with: python benchmarks/rod_bowline.py [FRICTION DRAG RUN] ...
"""

from __future__ import annotations

import sys

import numpy as np
from rod_common import bowline, table

import knotfem as kf


def run(friction: float, drag: float = 10.0, segments: int = 300) -> kf.Run:
    """Print what a run took."""
    scene = bowline(segments, contact__friction=friction, drag__rate=f"{drag} 1/s", drag__relaxing=f"{drag} 1/s")
    done = kf.pull("bowline", scene, progress=False)
    s, cost, energy = done.summary, done.cost, done.energy
    row: list[float | str] = [friction, drag, segments]
    row += [spent for name in ("relax", "pull") for spent in (cost.phases[name].wall_s, cost.phases[name].cpu_s)]
    row += [cost.steps, cost.newton_iterations, s["cutbacks"], s["max_penetration_over_d"], done.force.force[-1]]
    row += ["kept" if done.knot == s["knot_before"] else "LOST"]
    row += [energy[name][-1] / energy["work"][-1] for name in ("missing", "friction")]
    names = "mu drag segments rest/s CPU pull/s CPU steps iterations cut depth/d F/N knot missing/work friction/work"
    table("bowline", names.split(), [row])
    return done


def main() -> None:
    given = [(0.33, 10.0, "")]
    if len(sys.argv) > 1:
        given = [(float(a), float(b), c) for a, b, c in zip(*(sys.argv[k::3] for k in (1, 2, 3)), strict=True)]
    for friction, drag, path in given:
        force = run(friction, drag).force
        if path:
            solid = kf.open_run(path).force
            at = np.arange(6.0, min(force.displacement[-1], solid.displacement[-1]) + 1e-9, 6.0)
            rows = [(x, f, g, f / g - 1.0) for x, f, g in zip(at, force.at(at), solid.at(at), strict=True)]
            table(f"mu = {friction}", ("displacement mm", "rod N", "3D N", "difference"), rows)
    ends = [run(friction).force.force[-1] for friction in (0.30, 0.37)]
    print(f"force at 0.37 over that at 0.30: {ends[1] / ends[0]:.3f}")
    for segments in (150, 200, 450):
        run(0.33, segments=segments)


if __name__ == "__main__":
    main()
