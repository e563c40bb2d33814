"""The bowline with 300 segments: from the scene to rest, and pulled by 99 mm at 4 mm/s, with wall seconds.

Given the force.csv of runs in 3D, each with its friction and its rate of drag, it prints the forces side by side.

Run with: python benchmarks/rod_bowline.py [FRICTION DRAG RUN/force.csv] ...
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

import numpy as np
from rod_common import UP, bowline, hold_ends, rest, table

from knotfem.models.rod.ends import driven
from knotfem.models.rod.model import RodModel
from knotfem.solver.stepping.integrator import StepControl
from knotfem.topology.knot_type import knot_type

SPEED, WAY = 4.0, 99.0


def pull(model: RodModel, every: float = 3.0) -> tuple[np.ndarray, float, float]:
    """Displacement [mm] and force [N], shape [n, 2]; the worst account of a step over its work; deepest penetration."""
    since = model.time
    frame = model.end_frame(0, "start")
    model.begin({(0, "start"): driven(frame, UP, lambda now: min(SPEED * (now - since), WAY))})
    stops = since + np.arange(1, round(WAY / every) + 1) * every / SPEED
    control = StepControl(0.1 / SPEED, 1e-6, WAY / SPEED, model.layout.radius[0])
    curve, worst, deepest, work = [], 0.0, 0.0, model.ledger.energies.work
    for step in model.march(control, model.settings(), list(stops)):
        now = model.ledger.energies.work
        worst = min(worst, model.ledger.numerical_step / max(now - work, 1e-12), model.ledger.friction_step)
        work, deepest = now, max(deepest, model.penetration)
        if step.arrived:
            curve.append((SPEED * (model.time - since), model.reaction(0, "start") @ UP))
    return np.array(curve), worst, deepest


def run(friction: float, drag: float = 10.0, segments: int = 300) -> np.ndarray:
    """Print what a run took; returns its force curve."""
    model = bowline(friction, segments, drag=drag)
    before = knot_type(model.centreline()).name
    hold_ends(model)
    started = time.perf_counter(), time.process_time()
    rest(model)
    loose = time.perf_counter(), time.process_time()
    curve, worst, deepest = pull(model)
    end = time.perf_counter(), time.process_time()
    kept = knot_type(model.centreline()).name == before
    p, e = model.progress, model.ledger.energies
    row: list[float | str] = [friction, drag, segments]
    row += [b - a for first, after in ((started, loose), (loose, end)) for a, b in zip(first, after, strict=True)]
    row += [p.steps, p.iterations, p.cutbacks, deepest / (2.0 * model.layout.radius[0]), curve[-1, 1]]
    row += ["kept" if kept else "LOST", worst, e.friction / e.work]
    names = "mu drag segments rest/s CPU pull/s CPU steps iterations cut depth/d F/N knot account friction/work"
    table("bowline", names.split(), [row])
    return curve


def three_dimensional(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [mm] and force [N] of the pull of a run."""
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if row["step"] == "pull"]
    return (
        np.array([float(row["displacement_mm"]) for row in rows]),
        np.array([float(row["force_N"]) for row in rows]),
    )


def main() -> None:
    given = [(0.33, 10.0, None)]
    if len(sys.argv) > 1:
        given = [(float(a), float(b), Path(c)) for a, b, c in zip(*(sys.argv[k::3] for k in (1, 2, 3)), strict=True)]
    for friction, drag, path in given:
        curve = run(friction, drag)
        if path is not None:
            x, force = three_dimensional(path)
            rows = [(d, f, g := float(np.interp(d, x, force)), f / g - 1.0) for d, f in curve[::2]]
            table(f"mu = {friction}", ("displacement mm", "rod N", "3D N", "difference"), rows)
    ends = [run(friction)[-1, 1] for friction in (0.30, 0.37)]
    print(f"force at 0.37 over that at 0.30: {ends[1] / ends[0]:.3f}")
    for segments in (150, 200, 450):
        run(0.33, segments=segments)


if __name__ == "__main__":
    main()
