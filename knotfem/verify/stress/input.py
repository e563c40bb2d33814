"""Centrelines that are hard to tie: strands that overlap, and random curves."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

import knotfem as kf
from knotfem.errors import InputError, KnotLost, NotConverged, Stopped
from knotfem.geometry.clearance import strand_clearance
from knotfem.models.solid.body import build_body
from knotfem.scene import Scene
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.runs import folder, hard_case, hard_scene, run

CURVES = 200
MODES = 6
LONGEST = 90.0
"""Wall time after which tying counts as hung [s]."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""
    drawn = hard_scene("overlap", ("rods.0.length=259 mm", "rods.0.smoothing.iterations=0"), small=True)
    smoothed = hard_scene("overlap", ("rods.0.smoothing.iterations=7",) if small else (), small=small)
    random = hard_scene("random", small=True)

    def case(name: str, variant: str, title: str, measure: Callable[[], Sequence[Quantity]], scene: Scene) -> Case:
        return hard_case(name, variant, title, measure, scene, small=small)

    return [
        case("overlap", "drawn", "strands drawn 0.1 d into each other: refused", partial(_drawn, drawn), drawn),
        case(
            "overlap", "smoothed", "strands brought 0.1 d into each other by smoothing: separated",
            partial(_smoothed, smoothed), smoothed,
        ),
        case(
            "random", "", "smooth random curves: tied, or refused with a reason", partial(_random, small),
            random,
        ),
    ]  # fmt: skip


def _drawn(scene: Scene) -> Sequence[Quantity]:
    """A curve whose strands are closer than the diameter is refused, with the places."""
    try:
        build_body(scene)
        said = "accepted"
    except InputError as error:
        said = str(error)
    return [Quantity("refused, with the places", "overlaps itself at s/L" in said, True, kind="equal", condition=said)]


def _smoothed(scene: Scene) -> Sequence[Quantity]:
    """An overlap that only the smoothing has made gives a warning; contact then separates the strands."""
    body = build_body(scene)
    overlap = (
        1.0 - strand_clearance(body.rods[0].target.points, scene.rods[0].diameter).distance / scene.rods[0].diameter
    )
    found = run(scene)
    common = found.quantities(before="3_1", after="3_1", penetration=0.2)
    if not found.finished:
        return common
    last = found.tension["time_s"] == found.tension["time_s"][-1]
    centre = np.stack([found.tension[f"{axis}_mm"][last] for axis in "xyz"], axis=1)
    apart = strand_clearance(centre, scene.rods[0].diameter).distance / scene.rods[0].diameter
    return [
        *common,
        Quantity("overlap before / d", overlap, 0.1, 0.03, "absolute"),
        Quantity("warned", any("overlap" in warning for warning in body.warnings), True, kind="equal"),
        Quantity("strands apart after / d", apart, 0.9, kind="at least"),
    ]


def random_curve(seed: int) -> tuple[np.ndarray, bool]:
    """Points of a smooth curve, shape [n, 3], and whether it is closed: a Fourier series about a straight line."""
    rng = np.random.default_rng(seed)
    closed = seed % 4 == 0
    t = np.linspace(0.0, 1.0, 81)
    points = np.zeros((81, 3))
    for mode in range(1, MODES + 1):
        size = mode**-1.5 * rng.uniform(0.3, 1.0)
        wave = 2.0 * np.pi * mode * t if closed else np.pi * mode * t
        points += size * (np.outer(np.cos(wave), rng.normal(size=3)) + np.outer(np.sin(wave), rng.normal(size=3)))
    if not closed:
        points[:, 2] += rng.uniform(0.0, 6.0) * t
    return points, closed


def tie_random(seed: int, path: Path) -> str:
    """Tie a random curve.

    Returns:
        "tied" (mapped, and at rest in contact), "refused" (as all closed curves are), "gave up", "lost" or "hung".

    Raises:
        KnotfemError: any other error, a request to stop among them.
    """
    points, _ = random_curve(seed)
    curve = path / f"curve-{seed}.csv"
    rows = "\n".join(",".join(f"{value:.9g}" for value in point) for point in points)
    curve.write_text(f"# random {seed}\nx,y,z\n{rows}\n")
    overrides = [f"rods.0.centerline={curve}", f"solver.time_limit={LONGEST} s"]
    began = time.monotonic()
    try:
        scene = hard_scene("random", overrides, small=True)
        kf.tie(scene, out=path / f"run-{seed}", progress=False)
    except InputError:
        return "refused"
    except NotConverged:
        return "gave up"
    except KnotLost:
        return "lost"
    except Stopped:
        if time.monotonic() - began < LONGEST:
            raise
        return "hung"
    return "tied"


def _random(small: bool) -> Sequence[Quantity]:
    count = 6 if small else CURVES
    with folder() as path:
        seen = Counter(tie_random(seed, path) for seed in range(count))
    said = ", ".join(f"{number} {what}" for what, number in sorted(seen.items()))
    answered = seen["tied"] + seen["refused"]
    return [
        Quantity("tied or refused", float(answered), float(count), kind="at least", condition=said),
        Quantity("hung", float(seen["hung"]), 0.0, kind="at most"),
        Quantity("tied", float(seen["tied"]), 1.0 if small else 0.2 * count, kind="at least"),
    ]
