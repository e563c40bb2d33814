"""The bowline under a constant load: tension along it, and the friction at which it lets go.

As in the paper: loaded by T0 with the free end held, rest, free end let go under T0/20, rest; then friction is lowered
slowly until the knot unravels. The cylinder is frictionless. Tension between the knot and the cylinder follows from
balance alone: 0.475 T0 where the tail's load points down, 0.525 T0 where it points up.

Run with: python benchmarks/rod_stability.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from rod_common import GRAVITY, UP, bowline, hold_ends, rest, table

from knotfem.rod.ends import End, clamped, driven
from knotfem.rod.model import RodModel
from knotfem.solver.march import StepControl

RUN = 10.0
"""See `threshold` [mm]."""


class Schedule:
    """Friction as a share of what the model was made with; `lower` replaces it."""

    def __init__(self) -> None:
        self.share: Callable[[float], float] = lambda now: 1.0

    def __call__(self, now: float) -> float:
        return self.share(now)


def loaded(
    friction: float, softness: float, segments: int, tail: float, gravity: bool = True
) -> tuple[RodModel, Schedule, float]:
    """A bowline at rest under T0 = B/(softness r^2) and the tail's load `tail` T0 along z; its schedule, and T0 [N]."""
    schedule = Schedule()
    weight = GRAVITY if gravity else np.zeros(3)
    model = bowline(friction, segments, cylinder=0.0, drag=20.0, factor=schedule, gravity=weight)
    rod = model.rods[0]
    pull = rod.bending / (softness * rod.radius**2)
    hold_ends(model)
    rest(model)
    held, since = clamped(model.end_frame(0, "end")), model.time
    model.begin(
        {(0, "start"): driven(model.end_frame(0, "start"), UP, lambda now: 20.0 * (now - since)), (0, "end"): held}
    )
    control = StepControl(0.01, 1e-8, 10.0, rod.radius)
    for _ in model.march(control, model.settings(), [since + 8.0]):
        if model.reaction(0, "start") @ UP > pull:
            break
    load = End(force=lambda now: pull * UP)
    model.begin({(0, "start"): load, (0, "end"): held})
    rest(model)
    model.begin({(0, "start"): load, (0, "end"): End(force=lambda now: tail * pull * UP)})
    rest(model)
    return model, schedule, pull


def plateau(model: RodModel, pull: float) -> float:
    """Median tension of the two legs between the knot and the cylinder, over T0."""
    c, tension = model.contacts(), model.tension()
    middles = (np.arange(tension.size) + 0.5) * model.layout.spacing[0]
    peg, knot = c.arclength[c.other < 0], c.arclength[c.other >= 0]
    up = (middles > knot[knot < peg.min()].max()) & (middles < peg.min())
    down = (middles > peg.max()) & (middles < knot[knot > peg.max()].min())
    return float(np.median(tension[up | down]) / pull)


def threshold(
    friction: float, softness: float, segments: int, rate: float, gravity: bool = True
) -> tuple[float, float]:
    """Friction, lowered by `rate` [1/s], at which the knot runs, and how far it had crept before [mm].

    As friction falls the knot creeps from one equilibrium to the next; it runs once it moves on by `RUN` mm while
    friction falls by 0.002.
    """
    model, schedule, _ = loaded(friction, softness, segments, -0.05, gravity)
    since = model.time
    schedule.share = lambda now: max(1.0 - rate * (now - since) / friction, 0.0)
    place = float(model.x[0, 2])
    path = [(friction, 0.0)]
    control = StepControl(0.01, 1e-8, 0.0005 / rate, model.layout.radius[0])
    for _ in model.march(control, model.settings(), [since + friction / rate]):
        mu, moved = schedule(model.time) * friction, float(model.x[0, 2]) - place
        path.append((mu, moved))
        earlier = [p for p in path if p[0] >= mu + 0.002]
        if earlier and moved - earlier[-1][1] > RUN:
            return mu, earlier[-1][1]
    return 0.0, path[-1][1]


def main() -> None:
    rows = []
    for gravity in (False, True):
        for direction, expected in ((-0.05, 0.475), (0.05, 0.525)):
            model, _, pull = loaded(0.37, 5.0, 300, direction, gravity)
            found = plateau(model, pull)
            rows.append(("with" if gravity else "none", direction, found, expected, found / expected - 1.0))
    table("tension plateau over T0, x = 5", ("gravity", "tail/T0", "plateau", "expected", "deviation"), rows)
    rows = []
    for gravity in (False, True):
        for segments, rate in ((300, 0.01), (300, 0.005), (450, 0.01)):
            began = time.perf_counter()
            mu, crept = threshold(0.35, 9.1, segments, rate, gravity)
            rows.append(("with" if gravity else "none", segments, rate, mu, crept, time.perf_counter() - began))
    names = ("gravity", "segments", "mu lowered 1/s", "runs at mu", "crept before, mm", "wall s")
    table("friction lowered from 0.35 at x = 9.1", names, rows)


if __name__ == "__main__":
    main()
