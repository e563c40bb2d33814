"""Knots at the ends of the range: friction, bulk, core, stiffness of the rod, slip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from knotfem.scene.steps import Loaded, Release
from knotfem.verify.hard import Outcome, at, hard_scene, mesh_of, quantities_of, run
from knotfem.verify.rehearsal import Rehearsal
from knotfem.verify.verdict import Case, Quantity

SLIGHT = ("steps.1.displacement=2 mm", "output.every_displacement=1 mm")
"""A pull for small versions."""
ROUGH = ("contact.friction=1", "obstacles.0.friction=1")
FRICTIONLESS = ("contact.friction=0", "obstacles.0.friction=0", "steps.1.displacement=5 mm")
PART_OF_LAW = 0.5
"""Share of the largest tension up to which a capstan's band is looked at: beyond, the rod takes off."""
ABOVE_BENDING = 5.0
"""Times B/rho^2, from which tension on its bending does not count."""


def cases(*, small: bool = False) -> list[Case]:
    """See `hard.hard_cases`."""
    mesh = mesh_of(small)

    def case(name: str, variant: str, title: str, measure: Callable[..., Sequence[Quantity]]) -> Case:
        return Case(name, partial(measure, small=small), title, "hard cases", mesh, variant, slow=not small)

    def soft(x: str) -> Case:
        return case("soft", x, f"bowline at x = B/(T0 r^2) = {x}, friction 0.2, let go", partial(_soft, f"soft-{x}"))

    return [
        case("frictionless", "overhand", "overhand without friction, pulled until tight", _frictionless_overhand),
        case("frictionless", "bowline", "bowline without friction, pulled until out", _frictionless_bowline),
        case("rough", "overhand", "overhand with a friction of 1, pulled until tight", _rough_overhand),
        case("rough", "capstan", "three turns round a cylinder with a friction of 1", _rough_capstan),
        case("bulk", "", "tight overhand, bulk over shear 5,000 against 500", _bulk),
        case("core", "", "tight overhand without a core, with one 6e4 and 6e5 times as stiff", _core),
        soft("0.5"),
        soft("0.1"),
        case("stiff", "", "bowline at x = 100, held", _stiff),
        case("slip", "", "bowline at x = 25 and friction 0.1, let go: unravels", _slip),
        case("end", "", "free end that slips out of the knot", _end),
    ]


def _frictionless_overhand(*, small: bool) -> Sequence[Quantity]:
    found = run(hard_scene("overhand-frictionless", SLIGHT if small else (), small=small))
    common = found.quantities(before="3_1", after="3_1")
    return [*common, _tightens(found, small)] if found.finished else common


def _frictionless_bowline(*, small: bool) -> Sequence[Quantity]:
    found = run(
        hard_scene("end-off-cylinder", FRICTIONLESS, small=True) if small else hard_scene("bowline-frictionless")
    )
    if not found.finished:
        return found.quantities()
    friction = float(np.abs(found.force["friction_Nmm"]).max())
    return [
        *found.quantities(before="unknot" if small else "8_20", after="unknot"),
        Quantity("work of friction, N mm", friction, 0.0, kind="at most"),
    ]


def _rough_overhand(*, small: bool) -> Sequence[Quantity]:
    found = run(hard_scene("overhand-rough", SLIGHT if small else (), small=small))
    common = found.quantities(before="3_1", after="3_1")
    return [*common, _tightens(found, small)] if found.finished else common


def _tightens(found: Outcome, small: bool) -> Quantity:
    """Tight: the last mm takes more force than the mm at half the pull by far."""
    end = float(found.force["displacement_mm"][-1])
    ratio = at(found.force, end) / max(at(found.force, 0.5 * end), 1e-12)
    return Quantity("force at the end over force half way", ratio, 1.0 if small else 2.0, kind="at least")


def capstan_exponent(friction: float, rod_radius: float, cylinder_radius: float) -> float:
    """Lambda of T2/T1 = exp(Lambda phi) for a rod whose friction acts on its surface, not on its axis.

    With a = r/(R + r): mu a Lambda^2 + Lambda = mu (1 - a).
    """
    a = rod_radius / (rod_radius + cylinder_radius)
    return (np.sqrt(1.0 + 4.0 * friction**2 * a * (1.0 - a)) - 1.0) / (2.0 * friction * a)


def _rough_capstan(*, small: bool) -> Sequence[Quantity]:
    found = run(hard_scene("slip-capstan", ROUGH, small=True) if small else hard_scene("capstan-rough"))
    if not found.finished:
        return found.quantities()
    end = found.scene.steps[-1].ends["rod"].end
    assert isinstance(end, Loaded)
    ratio = float(found.force["force_N"][-1]) / end.force
    ends = Quantity("force ratio of the ends", ratio, 2.0 if small else 200.0, kind="at least")
    return [*found.quantities(), ends] if small else [*found.quantities(), ends, _sliding_band(found)]


def _sliding_band(found: Outcome) -> Quantity:
    """Force ratio over the part of the band where friction is spent and neither bending nor the last clamp counts."""
    rod, cylinder = found.scene.rods[0], found.scene.obstacles[0]
    last = found.tension["time_s"] == found.tension["time_s"][-1]
    tension, x, z = (found.tension[name][last] for name in ("tension_N", "x_mm", "z_mm"))
    angle = np.abs(np.unwrap(np.arctan2(x, z)))
    lies = 0.5 * (rod.diameter + cylinder.diameter)
    bending = rod.material.youngs_modulus * np.pi * rod.diameter**4 / 64.0 / lies**2
    rows = np.flatnonzero((tension > ABOVE_BENDING * bending) & (tension < PART_OF_LAW * tension.max()))
    low, high = rows[np.argmin(tension[rows])], rows[np.argmax(tension[rows])]
    exponent = capstan_exponent(found.scene.contact.friction, 0.5 * rod.diameter, 0.5 * cylinder.diameter)
    expected = float(np.exp(exponent * abs(angle[high] - angle[low])))
    return Quantity("ratio in the sliding band", float(tension[high] / tension[low]), expected, 0.05)


def _bulk(*, small: bool) -> Sequence[Quantity]:
    found: dict[str, tuple[float, float]] = {}
    figures: list[Quantity] = []
    for ratio in ("500", "5000"):
        overrides = (f"rods.0.material.bulk_over_shear={ratio}", *(SLIGHT if small else ()))
        rehearsal = Rehearsal(hard_scene("overhand-bulk-5000", overrides, small=small))
        force = 0.0
        for passed in rehearsal.run(rehearsal.tied()):
            force, figures = passed.balance.force, quantities_of(rehearsal, passed)
        found[ratio] = force, roughness(rehearsal.model.body.rods[0].bulk.pressure)
    return [
        *figures,
        Quantity("force, N", found["5000"][0], found["500"][0], 0.02),
        Quantity("roughness of the pressure", found["5000"][1], 1.2 * found["500"][1], kind="at most"),
    ]


def roughness(pressure: np.ndarray) -> float:
    """Share of an element pressure that alternates along the rod: near 0 if smooth, above 1 for a checkerboard.

    Args:
        pressure: shape [slices, quads, modes]; the first mode is looked at.
    """
    p = pressure[:, :, 0]
    alternating = p[1:-1] - 0.5 * (p[2:] + p[:-2])
    return float(np.sqrt(np.mean(alternating**2)) / np.std(p))


def _core(*, small: bool) -> Sequence[Quantity]:
    quantities: list[Quantity] = []
    classes: dict[str, float] = {}
    for name in ("overhand-core-6e4", "overhand-no-core", "overhand-core-6e5"):
        found = run(hard_scene(name, SLIGHT if small else (), small=small))
        quantities += found.quantities(before="3_1", after="3_1", condition=name.removeprefix("overhand-"))
        classes[name] = found.iterations / max(found.steps, 1)
    usual = classes.pop("overhand-core-6e4")
    quantities += [
        Quantity(f"iterations a step, {name.removeprefix('overhand-')}", count, 2.0 * usual, kind="at most")
        for name, count in classes.items()
    ]
    return quantities


def _release(found: Outcome) -> tuple[float, float]:
    """How long the release took and might have taken at most [s]."""
    step = next(step for step in found.scene.steps if isinstance(step, Release))
    rows = np.flatnonzero(found.force["step"] == step.name)
    time = found.force["time_s"]
    began = float(time[rows[0] - 1]) if rows[0] > 0 else 0.0
    return float(time[rows[-1]]) - began, step.duration


def _soft(name: str, *, small: bool) -> Sequence[Quantity]:
    if small:
        found = run(hard_scene("soft-crossing", ("steps.0.displacement=0.6 mm",), small=True))
        return found.quantities(penetration=0.2)
    found = run(hard_scene(name))
    if not found.finished:
        return found.quantities(before="8_20", penetration=0.2)
    took, longest = _release(found)
    rest = Quantity("time to rest, s", took, 0.999 * longest, kind="at most")
    return [*found.quantities(before="8_20", after="8_20", penetration=0.2), rest]


def _stiff(*, small: bool) -> Sequence[Quantity]:
    short = ("steps.1.duration=0.02 s", "steps.2.duration=0.02 s", "output.every_time=0.02 s")
    found = run(hard_scene("stiff-100", short if small else (), small=small))
    common = found.quantities(before="8_20", after="8_20")
    return [*common, _contacts(found)] if found.finished else common


def _contacts(found: Outcome) -> Quantity:
    """Contact at points: fewer samples than those of four patches as long as the rod is thick."""
    rod, contact = found.scene.rods[0], found.scene.contact
    spacing = contact.sample_spacing_over_diameter * rod.diameter
    ring = np.pi * rod.diameter / spacing
    most = float(np.ceil(4.0 * rod.diameter / spacing * ring))
    return Quantity("samples in contact", float(found.force["contacts"][-1]), most, kind="at most")


def _slip(*, small: bool) -> Sequence[Quantity]:
    found = run(hard_scene("slip-off-cylinder" if small else "slip", small=small))
    if not found.finished:
        return found.quantities()
    took, longest = _release(found)
    steps = np.array([row["step_s"] for row in found.log if row["phase"] in ("release", "caught")])
    shortest = int(np.argmin(steps))
    before, after = steps[: shortest + 1].max(), steps[shortest:].max()
    return [
        *found.quantities(after="unknot"),
        Quantity("time until recognised as lost, s", took, 0.999 * longest, kind="at most"),
        Quantity("shortest step over the longest before", float(steps[shortest] / before), 0.5, kind="at most"),
        Quantity("longest step after it over the shortest", float(after / steps[shortest]), 2.0, kind="at least"),
    ]


def _end(*, small: bool) -> Sequence[Quantity]:
    short = ("steps.1.displacement=5 mm",)
    found = run(hard_scene("end-off-cylinder", short, small=True) if small else hard_scene("end-slips-out"))
    if not found.finished:
        return found.quantities()
    left = float(found.force["contacts"][-1])
    return [*found.quantities(after="unknot"), Quantity("samples in contact at the end", left, 0.0, kind="at most")]
