"""Knots with extreme parameters: friction, core, bending stiffness, slip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from knotfem.scene import Scene
from knotfem.scene.steps import Loaded, Release
from knotfem.theory import tension_ratio
from knotfem.verify.case import Case, Quantity
from knotfem.verify.stress.outcome import Outcome
from knotfem.verify.stress.runs import SLIGHT, at, hard_case, hard_scene, run

BRIEF = (
    "steps.1.ends.rod.start.force=0.14 N", "steps.2.ends.rod.start.force=0.14 N", "quasi_static.tolerance=0.02"
)  # fmt: skip
"""A load for small versions: about what the end bears that was held."""
PRESSED = {"0.5": "2 mm", "0.1": "4 mm"}
"""Displacement by which small versions press soft rods into each other, by x."""
QUICK = ("steps.0.speed=20 mm/s", "inertia.scheme=backward-euler", "output.every_displacement=0.25 mm")
"""They are pressed so fast that they are not at rest when released."""
SQUEEZED = 0.2
"""Deepest penetration over the diameter where strands are squeezed flat."""
ROUGH = ("contact.friction=1", "obstacles.0.friction=1", "solver.move_over_diameter=0.25")
FRICTIONLESS = ("contact.friction=0", "obstacles.0.friction=0", "steps.1.displacement=5 mm")
PART_OF_LAW = 0.5
"""Fraction of the largest tension up to which a capstan's band is evaluated: beyond, the rod leaves the cylinder."""
ABOVE_BENDING = 5.0
"""Multiple of B/rho^2 above which bending has no influence on the tension."""


def cases(*, small: bool = False) -> list[Case]:
    """See `suite.hard_cases`."""

    def shipped(name: str, *short: str) -> Scene:
        return hard_scene(name, short if small else (), small=small)

    def simpler(name: str, other: str, *short: str) -> Scene:
        return hard_scene(other, short, small=True) if small else hard_scene(name)

    def case(name: str, variant: str, title: str, measure: Callable[..., Sequence[Quantity]], scene: Scene) -> Case:
        return hard_case(name, variant, title, partial(measure, scene, small=small), scene, small=small)

    def soft(x: str) -> Case:
        scene = simpler(f"soft-{x}", "soft-crossing", f"steps.0.displacement={PRESSED[x]}", *QUICK)
        return case("soft", x, f"bowline at x = B/(T0 r^2) = {x}, friction 0.2, released", _soft, scene)

    return [
        case(
            "frictionless", "overhand", "overhand without friction, pulled until tight", _tight,
            shipped("overhand-frictionless", *SLIGHT),
        ),
        case(
            "frictionless", "bowline", "bowline without friction, pulled until out", _frictionless_bowline,
            simpler("bowline-frictionless", "end-off-cylinder", *FRICTIONLESS),
        ),
        case(
            "rough", "overhand", "overhand with a friction of 1, pulled until tight", _tight,
            shipped("overhand-rough", *SLIGHT),
        ),
        case(
            "rough", "capstan", "three turns round a cylinder with a friction of 1", _rough_capstan,
            simpler("capstan-rough", "slip-capstan", *ROUGH),
        ),
        case(
            "core", "", "tight overhand without a core, with one 6e4 and 6e5 times as stiff", _core,
            shipped("overhand-core-6e4", *SLIGHT),
        ),
        soft("0.5"),
        soft("0.1"),
        case("stiff", "", "bowline at x = 100, held", _stiff, shipped("stiff-100", *BRIEF)),
        case(
            "slip", "", "bowline at x = 25 and friction 0.1, released: unravels", _slip,
            simpler("slip", "slip-off-cylinder"),
        ),
        case(
            "end", "", "free end that slips out of the knot", _end,
            simpler("end-slips-out", "end-off-cylinder", "steps.1.displacement=5 mm"),
        ),
    ]  # fmt: skip


def _tight(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="3_1", after="3_1")
    return [*common, _tightens(found, small)] if found.finished else common


def _frictionless_bowline(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="unknot" if small else "8_20", after="unknot")
    if not found.finished:
        return common
    friction = float(np.abs(found.force["friction_Nmm"]).max())
    return [
        *common,
        Quantity("work of friction, N mm", friction, 0.0, kind="at most"),
    ]


def _tightens(found: Outcome, small: bool) -> Quantity:
    """A knot tightens: at the end the force is much larger than at half the displacement."""
    end = float(found.force["step_displacement_mm"][-1])
    ratio = at(found.force, end) / max(at(found.force, 0.5 * end), 1e-12)
    return Quantity("force at the end over force half way", ratio, 1.0 if small else 2.0, kind="at least")


def _rough_capstan(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="unknot", after="unknot")
    if not found.finished:
        return common
    end = found.scene.steps[-1].ends["rod"].end
    assert isinstance(end, Loaded)
    ratio = float(found.force["force_N"][-1]) / end.force
    ends = Quantity("force ratio of the ends", ratio, 2.0 if small else 200.0, kind="at least")
    return [*common, ends] if small else [*common, ends, _sliding_band(found)]


def _sliding_band(found: Outcome) -> Quantity:
    """Force ratio over the part of the band that slides and that neither bending nor the last clamp influences."""
    rod, cylinder = found.scene.rods[0], found.scene.obstacles[0]
    last = found.tension["time_s"] == found.tension["time_s"][-1]
    tension, x, z = (found.tension[name][last] for name in ("tension_N", "x_mm", "z_mm"))
    angle = np.abs(np.unwrap(np.arctan2(x, z)))
    radius = 0.5 * (rod.diameter + cylinder.diameter)
    bending = rod.bending_stiffness / radius**2
    rows = np.flatnonzero((tension > ABOVE_BENDING * bending) & (tension < PART_OF_LAW * tension.max()))
    low, high = rows[np.argmin(tension[rows])], rows[np.argmax(tension[rows])]
    expected = tension_ratio(found.scene.contact.friction, abs(angle[high] - angle[low]), rod.radius / radius)
    return Quantity("ratio in the sliding band", float(tension[high] / tension[low]), expected, 0.05)


def _core(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    quantities: list[Quantity] = []
    iterations: dict[str, float] = {}
    others = {
        name: hard_scene(f"overhand-{name}", SLIGHT if small else (), small=small) for name in ("no-core", "core-6e5")
    }
    for name, of in {"core-6e4": scene, **others}.items():
        found = run(of)
        quantities += found.quantities(before="3_1", after="3_1", condition=name)
        iterations[name] = found.iterations / max(found.steps, 1)
    usual = iterations.pop("core-6e4")
    quantities += [
        Quantity(f"iterations per step, {name}", count, 2.0 * usual, kind="at most")
        for name, count in iterations.items()
    ]
    return quantities


def _release(found: Outcome) -> tuple[float, float]:
    """Duration of the release and its limit [s]."""
    step = next(step for step in found.scene.steps if isinstance(step, Release))
    rows = np.flatnonzero(found.force["step"] == step.name)
    time = found.force["time_s"]
    began = float(time[rows[0] - 1]) if rows[0] > 0 else 0.0
    return float(time[rows[-1]]) - began, step.duration


def _soft(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    knot = "unknot, unknot" if small else "8_20"
    found = run(scene)
    common = found.quantities(before=knot, after=knot, penetration=SQUEEZED)
    if not found.finished:
        return common
    duration, longest = _release(found)
    return [*common, Quantity("time to rest, s", duration, 0.999 * longest, kind="at most")]


def _stiff(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="8_20", after="8_20")
    return [*common, *contacts(found)] if found.finished else common


def contacts(found: Outcome) -> list[Quantity]:
    """Contact at points: at least one sample, and fewer than four patches as long as the diameter have."""
    rod, contact = found.scene.rods[0], found.scene.contact
    spacing = contact.sample_spacing_over_diameter * rod.diameter
    ring = np.pi * rod.diameter / spacing
    most = float(np.ceil(4.0 * rod.diameter / spacing * ring))
    touching = float(found.force["contacts"][-1])
    return [
        Quantity("samples in contact", touching, 1.0, kind="at least"),
        Quantity("samples in contact", touching, most, kind="at most"),
    ]


def _slip(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="unknot" if small else "8_20", after="unknot")
    if not found.finished:
        return common
    duration, longest = _release(found)
    steps = np.array([row["step_s"] for row in found.log if row["phase"] in ("release", "caught")])
    shortest = int(np.argmin(steps))
    before, after = steps[: shortest + 1].max(), steps[shortest:].max()
    return [
        *common,
        Quantity("time until recognised as lost, s", duration, 0.999 * longest, kind="at most"),
        Quantity("shortest step over the longest before", float(steps[shortest] / before), 0.5, kind="at most"),
        Quantity("longest step after it over the shortest", float(after / steps[shortest]), 2.0, kind="at least"),
    ]


def _end(scene: Scene, *, small: bool) -> Sequence[Quantity]:
    found = run(scene)
    common = found.quantities(before="unknot" if small else "3_1", after="unknot")
    if not found.finished:
        return common
    left = float(found.force["contacts"][-1])
    return [*common, Quantity("samples in contact at the end", left, 0.0, kind="at most")]
