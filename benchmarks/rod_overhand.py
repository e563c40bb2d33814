"""Loose open torus knots against Audoly's law, and longer braids against Jawed's.

Audoly, Clauvelin and Neukirch (2007): F r^2/B = eps^4/2 + mu sigma eps^3 with eps = sqrt(r/R), R the radius of the
loop, sigma = 0.492 (3_1), 1.475 (5_1), the first terms of an expansion in eps, in which all radii of the loop are one.
Two of them here: R_c of the loop's mean curvature between its contacts, R_d = drawn length / (2 pi). The energy depends
on the drawn length and on r alone; F and half the total contact force N are its derivatives, whence F = F_0 + mu N and,
by the drawn length, F_0 r^2/B = eps^4/2 (1 + 6 sigma eps/pi + ...). The last lines give what the ratios tend to.

Jawed et al. (2015), long braids: F/(B k^2) = 2 pi n mu r k, friction alone, with k the wave number of the braid, which
is (sqrt(12) r R)^(-1/2) as eps goes to 0. Two statements: each is looked at by itself, F also with the k that is found.

Run with: python benchmarks/rod_overhand.py [3_1] [5_1] [braids]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rod_common import rest, rubber, table, torus_knot, touching, unrest
from scipy.interpolate import CubicSpline

from knotfem.models.rod.ends import End, pinned
from knotfem.models.rod.model import RodModel
from knotfem.solver.stepping.integrator import StepControl
from knotfem.terms.inertia import Drag

SIGMA = {1: 0.492, 2: 1.475}
ALONG = np.array([1.0, 0.0, 0.0])
RANGES = (
    (345.0, (300.0,)), (230.0, (200.0,)), (150.0, (130.0,)), (95.0, (80.0,)), (62.0, (50.0,)), (45.0, (30.0, 20.0)),
)  # fmt: skip
"""First radius of a loop and those at which it is looked at, all in radii of the rod; each range has its own rod."""
RESOLUTION = 5.0
"""Segments on a length sqrt(r R) of the braid at the tightest."""


@dataclass(frozen=True)
class Frame:
    """A knot on its way.

    Attributes:
        curved: R_c, in radii of the rod.
        drawn: R_d, likewise.
        force: F [B/r^2].
        normal: N [B/r^2].
        sliding: share of the contacts that slide.
        drag: largest force of inertia and drag along the rod over F.
        wave: wave number of the braid [1/r].
    """

    curved: float
    drawn: float
    force: float
    normal: float
    sliding: float
    drag: float
    wave: float


def tighten(n: int, friction: float, first: float, loops: Sequence[float]) -> list[Frame]:
    """Pull a knot of r = 1 mm and loop radius `first` [mm] until that is `loops` [mm], with drag below 1 % of F."""
    radius = 1.0
    length = 2.0 * np.pi * first * 1.3 + 10.0 * (2 * n + 1) * np.sqrt(radius * first)
    segments = int(RESOLUTION * length / np.sqrt(radius * loops[-1]))
    points = torus_knot(n, radius, first, segments, length)
    model = RodModel([rubber(points, core=200.0, radius=radius)], touching(friction, radius), drag=20.0)
    model.begin({(0, side): pinned(model.end_frame(0, side)) for side in ("start", "end")})
    rest(model, 10.0, 1e-4)
    for effect in model.effects:
        if isinstance(effect, Drag):
            effect.rate = 0.2
    scale = model.rods[0].bending / radius**2
    result = []
    for loop in loops:
        speed = 8.0 * min(1.0, (30.0 / loop) ** 3)
        start, end, since = model.x[0, :3].copy(), model.x[-1, :3].copy(), model.time
        way = length - 2.0 * np.pi * loop - float(np.linalg.norm(end - start))
        model.begin({(0, "start"): _carried(start, -0.5 * speed, since), (0, "end"): _carried(end, 0.5 * speed, since)})
        move = max(4.0 * radius, 0.05 * loop)
        control = StepControl(0.08 / speed, 1e-8, 2.0 * move / speed, move)
        for _ in model.march(control, model.settings(1e-8 * scale), [since + way / speed]):
            pass
        result.append(_frame(model, scale))
    return result


def _carried(place: np.ndarray, speed: float, since: float) -> End:
    return End(place=lambda time: place + speed * (time - since) * ALONG)


def _frame(model: RodModel, scale: float) -> Frame:
    force = 0.5 * (model.reaction(0, "end") - model.reaction(0, "start"))[0]
    c, h, radius = model.contacts(), model.layout.spacing[0], model.layout.radius[0]
    middle = 0.5 * (c.arclength.min() + c.arclength.max())
    before, after = c.arclength[c.arclength < middle].max(), c.arclength[c.arclength > middle].min()
    curvature = model.bend.curvature(model.x)[int(before / h) + 1 : int(after / h) - 1].mean()
    drawn = h * model.layout.edges.size - float(np.linalg.norm(model.x[-1, :3] - model.x[0, :3]))
    sliding = float(c.normal_force[c.slides].sum() / c.normal_force.sum())
    return Frame(
        1.0 / (curvature * radius),
        drawn / (2.0 * np.pi * radius),
        force / scale,
        c.normal_force.sum() / scale,
        sliding,
        unrest(model) / force,
        _wave_number(model) * radius,
    )


def _wave_number(model: RodModel) -> float:
    """How fast the two strands turn about each other [1/mm], in the middle half of the braid."""
    c, x = model.contacts(), model.x[:, :3]
    first = c.arclength < c.other_arclength
    here, there = c.arclength[first], c.other_arclength[first]
    chosen = np.abs(here - 0.5 * (here.min() + here.max())) < 0.25 * np.ptp(here)
    order = np.argsort(here[chosen])
    here, there = here[chosen][order], there[chosen][order]
    curve = CubicSpline(model.layout.spacing[0] * np.arange(len(x)), x)
    across, axis = _unit(curve(there) - curve(here)), _unit(curve(here, 1) + curve(there, 1))
    way = np.linalg.norm(np.diff(0.5 * (curve(here) + curve(there)), axis=0), axis=1)
    turned = np.einsum("ij,ij->i", np.cross(across[:-1], across[1:]), 0.5 * (axis[:-1] + axis[1:]))
    return float(abs(turned.sum()) / way.sum())


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def limit(eps: np.ndarray, ratio: np.ndarray) -> tuple[float, float]:
    """Value and slope at eps = 0 of a parabola through the four smallest."""
    chosen = np.argsort(eps)[:4]
    fit = np.polynomial.Polynomial.fit(eps[chosen], ratio[chosen], 2).convert().coef
    return float(fit[0]), float(fit[1])


def law(n: int, mu: float, eps: float) -> float:
    """F r^2/B."""
    return 0.5 * eps**4 + mu * SIGMA[n] * eps**3


def audoly(n: int, coefficients: Sequence[float]) -> None:
    rows, smooth = [], []
    for mu in coefficients:
        frames = [frame for first, loops in RANGES for frame in tighten(n, mu, first, loops)]
        if mu == 0.0:
            smooth = frames
        for f, plain in zip(frames, smooth, strict=True):
            c, d = f.curved**-0.5, f.drawn**-0.5
            part = (f.force - plain.force) / (mu * f.normal) if mu else np.nan
            row = [mu, c, f.force / law(n, mu, c), f.normal / (SIGMA[n] * c**3)]
            rows.append([*row, d, f.force / law(n, mu, d), f.normal / (SIGMA[n] * d**3), part, f.sliding, f.drag])
    names = ("mu", "eps_c", "F/law", "N/law", "eps_d", "F/law", "N/law", "(F-F0)/mu N", "sliding", "drag/F")
    table(f"open (2, {2 * n + 1}) torus knot against Audoly's law", names, rows)
    found = np.array(rows)[: len(smooth)]
    for name, k in (("mean curvature", 1), ("drawn length", 4)):
        bending, normal = limit(found[:, k], found[:, k + 1]), limit(found[:, k], found[:, k + 2])
        print(f"by {name}: F_0/law tends to {bending[0]:.3f} + {bending[1]:.2f} eps", end=", ")
        print(f"N/law to {normal[0]:.3f} + {normal[1]:.2f} eps")
    print(f"6 sigma/pi = {6.0 * SIGMA[n] / np.pi:.2f}")


def jawed(n: int, friction: float) -> None:
    """Friction is mu times the normal force without it, to first order; and what an end needs more with it."""
    rows = []
    for first, loops in RANGES:
        pairs = zip(tighten(n, 0.0, first, loops), tighten(n, friction, first, loops), strict=True)
        for smooth, rough in pairs:
            k = (np.sqrt(12.0) * rough.curved) ** -0.5
            loss = (rough.force - smooth.force) / friction
            row = [rough.curved**-0.5, rough.wave / k]
            for wave, normal in ((k, loss), (rough.wave, loss), (smooth.wave, smooth.normal)):
                row.append(normal / (2.0 * np.pi * n * wave**3))
            rows.append([*row, rough.sliding, rough.drag])
    names = ("eps_c", "k/law", "F/law", "F/law, k found", "N/law, k found, mu = 0", "sliding", "drag/F")
    table(f"braid of n = {n} against Jawed's law, mu = {friction}", names, rows)


def main() -> None:
    wanted = sys.argv[1:] or ["3_1", "5_1", "braids"]
    if "3_1" in wanted:
        audoly(1, (0.0, 0.05, 0.1))
    if "5_1" in wanted:
        audoly(2, (0.0, 0.05, 0.1))
    if "braids" in wanted:
        for n in (2, 3):
            jawed(n, 0.1)


if __name__ == "__main__":
    main()
