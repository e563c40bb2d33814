"""The bowline under a constant load: tension along it, and the friction at which it unravels.

As in the paper: loaded by T0 with the free end held, rest, free end let go under T0/20, rest. Then either friction is
lowered slowly until the knot unravels (the paper's discrete elements), or the knot is made and kept at one friction
(its finite elements). The cylinder is frictionless where tension is looked at; the paper does not say what it is where
stability is, so both its coefficients are tried. Tension between the knot and the cylinder follows from
balance alone: 0.475 T0 where the tail's load points down, 0.525 T0 where it points up.

Run with: python benchmarks/rod_stability.py [plateau] [lowered] [kept]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from rod_common import YOUNGS, bowline, table

import knotfem as kf
from knotfem.geometry.frames import tangents
from knotfem.topology.knot_type import knot_type

RUN, FALL = 10.0, 0.002
"""A knot runs where it moves on by so many mm while friction falls by so much."""
GONE = 250.0
"""A knot has unravelled, at the latest, when its loading end has come this far [mm]."""
BENDING_FORCE = 9.0 * np.pi * YOUNGS / 4.0
"""B/r^2 [N]."""
LET_GO = {"name": "let-go", "kind": "release", "duration": "100 s"}


def loaded(
    friction: float,
    softness: float,
    segments: int,
    steps: Sequence[dict[str, Any]],
    *,
    tail: float = -0.05,
    gravity: bool = False,
    cylinder: float = 0.0,
    outputs: float = 1.0,
) -> kf.Scene:
    """A bowline under T0 = B/(softness r^2), the free end held; in `steps` it bears the load `tail` T0 along z.

    Outputs are due each `outputs` seconds; then it is looked at whether the knot is lost.
    """
    pulled, drawn = (
        {"motion": "loaded", "force": f"{size * BENDING_FORCE / softness} N", "direction": [0, 0, way]}
        for size, way in ((1.0, 1), (abs(tail), 1 if tail > 0.0 else -1))
    )
    made: list[dict[str, Any]] = [
        {"kind": "relax"},
        {"kind": "load", "duration": "8 s", "ends": {"rod": {"start": pulled}}},
        {"name": "rest", "kind": "relax", "ends": {"rod": {"start": pulled}}},
    ]
    made += [{**step, "ends": {"rod": {"start": pulled, "end": drawn}}} for step in steps]
    changed = bowline(segments, contact__friction=friction, obstacles__0__friction=cylinder, steps=made)
    weight = {"gravity": {"acceleration": "9.81 m/s^2"}} if gravity else {}
    return kf.load_scene("bowline-lowered", {**changed, **weight, "output.every_time": f"{outputs} s"})


def plateau(direction: float, gravity: bool) -> float:
    """Median tension of the two legs between the knot and the cylinder, over T0."""
    run = kf.pull(loaded(0.37, 5.0, 300, [LET_GO], tail=direction, gravity=gravity), progress=False)
    profile, c = run.tension(), run.contacts()
    s, on_peg = profile.arclength, c["other"] != "rod"
    peg, knot = c["arclength_mm"][on_peg], c["arclength_mm"][~on_peg]
    up = (s > knot[knot < peg.min()].max()) & (s < peg.min())
    down = (s > peg.max()) & (s < knot[knot > peg.max()].min())
    return float(np.median(profile.tension[up | down])) * 5.0 / BENDING_FORCE


def lowered(
    friction: float, softness: float, segments: int, rate: float, cylinder: float
) -> tuple[float, float, float]:
    """Friction, lowered by `rate` [1/s], at which the knot runs, its way until then [mm], and where it is lost.

    As friction falls the knot creeps from one equilibrium to the next. It runs once it moves on by `RUN` mm while
    friction falls by `FALL`, and is lost when its free end has been drawn into it, so that it is another knot or none.
    """
    duration = friction / rate
    schedule = [{"time": "0 s", "friction": friction}, {"time": f"{duration} s", "friction": 0.0}]
    lower = {"name": "lower", "kind": "release", "duration": f"{duration} s", "friction_schedule": schedule}
    scene = loaded(
        friction,
        softness,
        segments,
        [{**LET_GO, "must_hold": True}, lower],
        cylinder=cylinder,
        outputs=FALL / rate,
    )
    path, runs, before = [(friction, 0.0)], (0.0, 0.0), np.zeros((0, 3))
    for step in kf.steps(scene):
        points = step.state.x[:, :3]
        if step.step.name != "lower":
            before = points
            continue
        mu, moved = max(friction - rate * step.elapsed, 0.0), float(points[0, 2] - before[0, 2])
        path.append((mu, moved))
        earlier = [p for p in path if p[0] >= mu + FALL]
        if not runs[0] and earlier and moved - earlier[-1][1] > RUN:
            runs = mu, earlier[-1][1]
        t = tangents(before)
        if moved > GONE or (moved > RUN and knot_type(points, (-t[0], t[-1])).name != knot_type(before).name):
            break
    return *runs, path[-1][0]


def kept(friction: float, softness: float, cylinder: float) -> bool:
    """Whether a knot made at this friction comes to rest once its free end is let go."""
    run = kf.pull(loaded(friction, softness, 300, [LET_GO], cylinder=cylinder), progress=False)
    force = run.table("force")
    waited = np.ptp(force["time_s"][force["step"] == LET_GO["name"]])
    return run.knot == run.summary["knot_before"] and waited < 99.0


def bracket(softness: float, cylinder: float) -> tuple[float, float]:
    """Frictions, 0.01 apart, at which the knot unravels and stays."""
    low, high = 5, 35
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if kept(0.01 * middle, softness, cylinder) else (middle, high)
    return 0.01 * low, 0.01 * high


def plateaus() -> None:
    rows = []
    for gravity in (False, True):
        for direction, expected in ((-0.05, 0.475), (0.05, 0.525)):
            found = plateau(direction, gravity)
            rows.append(("with" if gravity else "none", direction, found, expected, found / expected - 1.0))
    table("tension plateau over T0, x = 5", ("gravity", "tail/T0", "plateau", "expected", "deviation"), rows)


def thresholds_lowered() -> None:
    rows = []
    for cylinder, rates in ((0.39, (0.05, 0.025, 0.0125, 0.00625)), (0.0, (0.02, 0.01))):
        for segments in (150, 300):
            for rate in rates:
                began = time.process_time()
                found = lowered(0.35, 9.1, segments, rate, cylinder)
                rows.append((cylinder, segments, rate, *found, time.process_time() - began))
                print(*rows[-1], file=sys.stderr)
    names = ("mu cylinder", "segments", "mu lowered 1/s", "runs at", "crept before, mm", "lost at", "CPU s")
    table("friction lowered from 0.35 at x = 9.1, no gravity", names, rows)


def thresholds_kept() -> None:
    rows = []
    for softness in (5.0, 9.1, 25.0):
        for cylinder in (0.0, 0.39):
            rows.append((softness, cylinder, *bracket(softness, cylinder), kf.theory.stiff_friction(softness)))
    table("friction kept", ("x", "mu cylinder", "unravels at", "stays at", "fitted law"), rows)


def main() -> None:
    wanted = sys.argv[1:] or ["plateau", "lowered", "kept"]
    for name, measure in (("plateau", plateaus), ("lowered", thresholds_lowered), ("kept", thresholds_kept)):
        if name in wanted:
            measure()


if __name__ == "__main__":
    main()
