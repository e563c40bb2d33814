"""Loose open torus knots against Audoly's law, and longer braids against Jawed's.

Audoly, Clauvelin and Neukirch (2007): F r^2/B = eps^4/2 + mu sigma eps^3 with eps = sqrt(r/R), R the radius of the loop
(here: of its mean curvature), sigma = 0.492 (3_1), 1.475 (5_1), the first terms of an expansion in eps. Since F is the
slope of the energy by the drawn length and the total contact force N half its slope by r, mu enters through F = F_0 +
mu N; the rows give N over sigma eps^3 B/r^2 as well, and the last line what both ratios tend to as eps goes to 0.

Jawed et al. (2015), long braids: F/(B k^2) = 2 pi n mu r k with k = (sqrt(12) r R)^(-1/2).

Run with: python benchmarks/rod_overhand.py
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rod_common import rest, rubber, table, torus_knot, touching, unrest

from knotfem.effects.inertia import Drag
from knotfem.rod.ends import End, pinned
from knotfem.rod.model import RodModel
from knotfem.solver.march import StepControl

SIGMA = {1: 0.492, 2: 1.475}
ALONG = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Frame:
    """A knot on its way: radius of the loop over that of the rod, F and N in B/r^2, share of contacts that slide."""

    loop: float
    force: float
    normal: float
    sliding: float
    drag: float

    @property
    def eps(self) -> float:
        return self.loop**-0.5


def tighten(n: int, friction: float, loops: list[float], segments: int, first: float) -> list[Frame]:
    """Pull a knot of r = 1 mm and first loop radius `first` [mm] slowly until its loop has the radii `loops` [mm]."""
    radius = 1.0
    length = 2.0 * np.pi * first * 1.3 + 10.0 * (2 * n + 1) * np.sqrt(radius * first)
    points = torus_knot(n, radius, first, segments, length)
    model = RodModel([rubber(points, core=200.0, radius=radius)], touching(friction, radius), drag=20.0)
    model.begin({(0, side): pinned(model.end_frame(0, side)) for side in ("start", "end")})
    rest(model, 10.0, 1e-4)
    for effect in model.effects:
        if isinstance(effect, Drag):
            effect.rate = 0.2
    start, end, since, speed = model.x[0, :3].copy(), model.x[-1, :3].copy(), model.time, 8.0

    def carried(place: np.ndarray, way: float) -> End:
        return End(place=lambda time: place + 0.5 * way * speed * (time - since) * ALONG)

    model.begin({(0, "start"): carried(start, -1.0), (0, "end"): carried(end, 1.0)})
    drawn = [length - 2.0 * np.pi * loop - np.linalg.norm(end - start) for loop in loops]
    stops = [since + d / speed for d in drawn]
    scale = model.rods[0].bending / radius**2
    result = []
    for step in model.march(StepControl(0.01, 1e-8, 1.0, 4.0 * radius), model.settings(1e-7 * scale), stops):
        if step.arrived:
            result.append(_frame(model, scale))
    return result


def _frame(model: RodModel, scale: float) -> Frame:
    force = 0.5 * (model.reaction(0, "end") - model.reaction(0, "start"))[0]
    c, h, radius = model.contacts(), model.layout.spacing[0], model.layout.radius[0]
    middle = 0.5 * (c.arclength.min() + c.arclength.max())
    before, after = c.arclength[c.arclength < middle].max(), c.arclength[c.arclength > middle].min()
    curvature = model.bend.curvature(model.x)[int(before / h) + 1 : int(after / h) - 1].mean()
    sliding = float(c.normal_force[c.slides].sum() / c.normal_force.sum())
    return Frame(
        1.0 / (curvature * radius), force / scale, c.normal_force.sum() / scale, sliding, unrest(model) / force
    )


def limit(eps: np.ndarray, ratio: np.ndarray) -> float:
    """Value at eps = 0 of a parabola through the ratios."""
    return float(np.polyval(np.polyfit(eps, ratio, 2 if eps.size > 3 else 1), 0.0))


def audoly(n: int, coefficients: list[float], loops: list[float], segments: int, first: float) -> None:
    rows, ratios = [], {}
    for mu in coefficients:
        for f in tighten(n, mu, loops, segments, first):
            law = 0.5 * f.eps**4 + mu * SIGMA[n] * f.eps**3
            normal = f.normal / (SIGMA[n] * f.eps**3)
            rows.append((mu, f.eps, f.force, law, f.force / law, normal, f.sliding, f.drag))
            if mu == 0.0:
                ratios[f.eps] = (f.force / law, normal)
    names = ("mu", "eps", "F r^2/B", "law", "ratio", "N ratio", "sliding", "drag/F")
    table(f"open (2, {2 * n + 1}) torus knot against Audoly's law", names, rows)
    if ratios:
        eps = np.array(list(ratios))
        bending, normal = np.array(list(ratios.values())).T
        print(f"as eps goes to 0 the bending term tends to {limit(eps, bending):.3f}, N to {limit(eps, normal):.3f}")


def jawed(n: int, coefficients: list[float], loops: list[float], segments: int, first: float) -> None:
    rows = []
    slippery = {f.loop: f.force for f in tighten(n, 0.0, loops, segments, first)}
    for mu in coefficients:
        for f in tighten(n, mu, loops, segments, first):
            k = (np.sqrt(12.0) * f.loop) ** -0.5
            plain = float(np.interp(f.loop, sorted(slippery), [slippery[key] for key in sorted(slippery)]))
            law = 2.0 * np.pi * n * mu * k**3
            rows.append((mu, f.eps, f.force / k**2, law / k**2, f.force / law, (f.force - plain) / law, f.sliding))
    names = ("mu", "eps", "F/(B k^2)", "law", "ratio", "friction's part", "sliding")
    table(f"braid of n = {n} against Jawed's law", names, rows)


def main() -> None:
    audoly(1, [0.0, 0.05, 0.1], [300.0, 200.0, 130.0, 80.0, 50.0, 30.0, 18.0], 900, 400.0)
    audoly(2, [0.0, 0.05, 0.1], [300.0, 200.0, 130.0, 80.0, 50.0, 30.0], 900, 400.0)
    for n in (2, 3):
        jawed(n, [0.1, 0.2], [150.0, 100.0, 70.0, 50.0], 700, 200.0)


if __name__ == "__main__":
    main()
