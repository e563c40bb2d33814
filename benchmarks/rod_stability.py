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
from collections.abc import Callable

import numpy as np
from rod_common import GRAVITY, UP, bowline, hold_ends, rest, table, unrest

from knotfem.geometry.frames import tangents
from knotfem.models.rod.ends import End, clamped, driven
from knotfem.models.rod.model import RodModel
from knotfem.solver.stepping.integrator import StepControl
from knotfem.topology.knot_type import knot_type

RUN, FALL = 10.0, 0.002
"""A knot runs where it moves on by so many mm while friction falls by so much."""
GONE = 250.0
"""A knot has unravelled, at the latest, when its loading end has come this far [mm]."""


class Schedule:
    """Friction as a share of what the model was made with; `lower` replaces it."""

    def __init__(self) -> None:
        self.share: Callable[[float], float] = lambda now: 1.0

    def __call__(self, now: float) -> float:
        return self.share(now)


def loaded(
    friction: float,
    softness: float,
    segments: int,
    tail: float,
    gravity: bool = True,
    cylinder: float = 0.0,
    settled: bool = True,
) -> tuple[RodModel, Schedule, float]:
    """A bowline under T0 = B/(softness r^2) and the tail's load `tail` T0 along z; its schedule, and T0 [N].

    It is at rest, or else the tail has just been let go.
    """
    schedule = Schedule()
    weight = GRAVITY if gravity else np.zeros(3)
    model = bowline(friction, segments, cylinder=cylinder, drag=20.0, factor=schedule, gravity=weight)
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
    if settled:
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


class Named:
    """The knot of a model, its ends continued as they lie now."""

    def __init__(self, model: RodModel) -> None:
        t = tangents(model.centreline())
        self.model, self.ends = model, (-t[0], t[-1])
        self.before = self.name()

    def name(self) -> str:
        return knot_type(self.model.centreline(), self.ends).name

    @property
    def lost(self) -> bool:
        return self.name() != self.before


def lowered(
    friction: float, softness: float, segments: int, rate: float, gravity: bool, cylinder: float
) -> tuple[float, float, float]:
    """Friction, lowered by `rate` [1/s], at which the knot runs, its way until then [mm], and where it is lost.

    As friction falls the knot creeps from one equilibrium to the next. It runs once it moves on by `RUN` mm while
    friction falls by `FALL`, and is lost when its free end has been drawn into it, so that it is another knot or none.
    """
    model, schedule, _ = loaded(friction, softness, segments, -0.05, gravity, cylinder)
    knot, since, place = Named(model), model.time, float(model.x[0, 2])
    schedule.share = lambda now: max(1.0 - rate * (now - since) / friction, 0.0)
    path, runs = [(friction, 0.0)], (0.0, 0.0)
    control = StepControl(0.01, 1e-8, 0.25 * FALL / rate, model.layout.radius[0])
    for _ in model.march(control, model.settings(), [since + friction / rate]):
        mu, moved = schedule(model.time) * friction, float(model.x[0, 2]) - place
        path.append((mu, moved))
        earlier = [p for p in path if p[0] >= mu + FALL]
        if not runs[0] and earlier and moved - earlier[-1][1] > RUN:
            runs = mu, earlier[-1][1]
        if moved > GONE or (moved > RUN and knot.lost):
            return *runs, mu
    return *runs, 0.0


def kept(friction: float, softness: float, segments: int, gravity: bool, cylinder: float) -> bool:
    """Whether a knot made at this friction comes to rest once its free end is let go."""
    model, _, _ = loaded(friction, softness, segments, -0.05, gravity, cylinder, settled=False)
    place, limit = float(model.x[0, 2]), 2e-5 * model.rods[0].bending / model.rods[0].radius ** 2
    knot = Named(model)
    control = StepControl(0.01, 1e-8, 10.0, model.layout.radius[0])
    for _ in model.march(control, model.settings(), [model.time + 100.0]):
        if model.x[0, 2] - place > GONE or not (model.contacts().other >= 0).any():
            return False
        if unrest(model) < limit and model.ledger.energies.kinetic < 1e-6 * model.ledger.energies.elastic:
            return not knot.lost
    return False


def bracket(softness: float, segments: int, gravity: bool, cylinder: float) -> tuple[float, float]:
    """Frictions, 0.01 apart, at which the knot unravels and stays."""
    low, high = 5, 35
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if kept(0.01 * middle, softness, segments, gravity, cylinder) else (middle, high)
    return 0.01 * low, 0.01 * high


def with_or_none(gravity: bool) -> str:
    return "with" if gravity else "none"


def plateaus() -> None:
    rows = []
    for gravity in (False, True):
        for direction, expected in ((-0.05, 0.475), (0.05, 0.525)):
            model, _, pull = loaded(0.37, 5.0, 300, direction, gravity)
            found = plateau(model, pull)
            rows.append((with_or_none(gravity), direction, found, expected, found / expected - 1.0))
    table("tension plateau over T0, x = 5", ("gravity", "tail/T0", "plateau", "expected", "deviation"), rows)


def thresholds_lowered() -> None:
    rows = []
    for cylinder, rates in ((0.39, (0.05, 0.025, 0.0125, 0.00625)), (0.0, (0.02, 0.01))):
        for segments in (150, 300):
            for rate in rates:
                began = time.process_time()
                found = lowered(0.35, 9.1, segments, rate, False, cylinder)
                rows.append((cylinder, segments, rate, *found, time.process_time() - began))
                print(*rows[-1], file=sys.stderr)
    names = ("mu cylinder", "segments", "mu lowered 1/s", "runs at", "crept before, mm", "lost at", "CPU s")
    table("friction lowered from 0.35 at x = 9.1, no gravity", names, rows)


def thresholds_kept() -> None:
    rows = []
    for softness, theory in ((5.0, 0.0895), (9.1, 0.1352), (25.0, 0.2716)):
        for cylinder in (0.0, 0.39):
            rows.append((softness, cylinder, *bracket(softness, 300, False, cylinder), theory))
    table("friction kept", ("x", "mu cylinder", "unravels at", "stays at", "fitted law"), rows)


def main() -> None:
    wanted = sys.argv[1:] or ["plateau", "lowered", "kept"]
    for name, measure in (("plateau", plateaus), ("lowered", thresholds_lowered), ("kept", thresholds_kept)):
        if name in wanted:
            measure()


if __name__ == "__main__":
    main()
