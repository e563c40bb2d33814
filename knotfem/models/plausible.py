"""Values of a scene that are not wrong but unusual, each with a reason; a run says them once and goes on."""

from __future__ import annotations

import os
from collections.abc import Iterator
from math import isclose, sqrt

from knotfem.scene.model import Scene
from knotfem.scene.rods import Material
from knotfem.scene.steps import Loaded, Pull
from knotfem.solver.nonlinear.tolerance import ForceTolerance

MODULUS = (1e-3, 2e6)
"""Between soft gels and diamond [MPa]."""
DENSITY = (1e-11, 2.3e-8)
"""Between aerogels and osmium [tonne/mm^3]."""
DIAMETER = (1e-2, 1e3)
"""Between thin fibres and the thickest ropes [mm]."""
FRICTION = 2.0
"""Rubber on dry glass has 1 to 2."""
DRAG = 1e3
"""Air and water slow ropes down at rates far below [1/s]."""
GRAVITY = 1e5
"""Ten times that of the Earth [mm/s^2]."""
SPEED_OVER_WAVES = 0.01
"""A pull in real time that is faster, compared to waves along the rod, is an impact."""
LOAD_OVER_STIFFNESS = 0.3
"""A force that is larger, compared to the axial stiffness, stretches the rod by tens of percent."""
LOOSE_FORCE = 0.03
"""Force of a loose knot, in units of B/r^2."""
PROMISED = 0.01
"""Fraction of the force that the solver's tolerance should not exceed."""


def unusual(scene: Scene) -> list[str]:
    """A sentence for each unusual value, which begins with its key."""
    return [*_rope(scene), *_rods(scene), *_contact(scene), *_steps(scene), *_solver(scene)]


def _rope(scene: Scene) -> Iterator[str]:
    """Where a scene for another rope is not similar to the one that it was made from."""
    rope = scene.rope
    if rope is None:
        return
    if scene.gravity is not None and scene.gravity.acceleration > 0.0 and not isclose(rope.weight, 1.0, rel_tol=1e-6):
        similar = scene.gravity.acceleration / rope.weight / 1000.0
        yield (
            f"gravity.acceleration: the rope's weight over its stiffness, rho g d / E, is {rope.weight:.3g} times that "
            f'of {rope.scene}, so that the scene is not similar; "{similar:.4g} m/s^2" would keep it so, none leaves '
            "weight out"
        )
    if any(step.real for step in scene.steps) and not isclose(rope.inertia, 1.0, rel_tol=1e-6):
        yield (
            f"steps: in real time inertia over stiffness, rho v^2 / E, is {rope.inertia:.3g} times that of "
            f"{rope.scene}, since times stay as they were"
        )
    if scene.effects.viscous_drag is not None:
        yield "effects.viscous_drag: the fluid is not scaled"


def _rods(scene: Scene) -> Iterator[str]:
    for i, rod in enumerate(scene.rods):
        key = f"rods.{i}"
        yield from _outside(f"{key}.material.youngs_modulus", rod.material.youngs_modulus, MODULUS, "MPa", _MATTER)
        if rod.core is not None:
            yield from _outside(f"{key}.core.youngs_modulus", rod.core.youngs_modulus, MODULUS, "MPa", _MATTER)
        yield from _outside(f"{key}.material.density", rod.material.density, DENSITY, "tonne/mm^3", _DENSE)
        yield from _outside(f"{key}.diameter", rod.diameter, DIAMETER, "mm", "fibres and ropes are thicker or thinner")
        if rod.mesh.element_length > rod.diameter:
            found = f"{rod.mesh.element_length:g} mm"
            yield f"{key}.mesh.element_length: {found} is longer than the rod is thick; contact in a knot is coarse"


_MATTER = "soft gels have 1e-3 MPa, diamond 1e6 MPa"
_DENSE = "water has 1e-9 tonne/mm^3"


def _contact(scene: Scene) -> Iterator[str]:
    found = {"contact.friction": scene.contact.friction}
    found |= {f"obstacles.{i}.friction": obstacle.friction for i, obstacle in enumerate(scene.obstacles)}
    found |= {f"contact.pairs.{i}.friction": pair.friction for i, pair in enumerate(scene.contact.pairs)}
    for key, friction in found.items():
        if friction > FRICTION:
            yield f"{key}: a coefficient of {friction:g} is unusual; rubber on dry glass has 1 to 2"
    if scene.drag is not None and max(scene.drag.rate, scene.drag.relaxing or 0.0) > DRAG:
        yield f"drag.rate: {scene.drag.rate:g} 1/s is unusual; the rods hardly move against it"
    if scene.gravity is not None and scene.gravity.acceleration > GRAVITY:
        yield f"gravity.acceleration: {scene.gravity.acceleration:g} mm/s^2 is more than ten times that of the Earth"


def _steps(scene: Scene) -> Iterator[str]:
    slowest = min(_wave_speed(rod.material) for rod in scene.rods)
    rods = {rod.name: rod for rod in scene.rods}
    for i, step in enumerate(scene.steps):
        if isinstance(step, Pull):
            if step.real and step.nominal_speed > SPEED_OVER_WAVES * slowest:
                said = f"{step.nominal_speed:g} mm/s is {step.nominal_speed / slowest:.2g} of the speed of waves"
                yield f"steps.{i}.speed: {said} along the rod, {slowest:.3g} mm/s; this is an impact, not a pull"
            longest = max(rod.length for rod in scene.rods)
            if step.displacement > longest:
                yield f"steps.{i}.displacement: {step.displacement:g} mm is more than the length of a rod"
        for (name, side), end in step.all_ends().items():
            if isinstance(end, Loaded) and end.force > LOAD_OVER_STIFFNESS * rods[name].axial_stiffness:
                stretch = end.force / rods[name].axial_stiffness
                said = (
                    f"{end.force:g} N over the axial stiffness of {rods[name].axial_stiffness:.3g} N is {stretch:.2g}"
                )
                yield f"steps.{i}.ends.{name}.{side}.force: {said}; the rod is stretched far beyond what knots need"


def _wave_speed(material: Material) -> float:
    return sqrt(material.youngs_modulus / material.density)


def _solver(scene: Scene) -> Iterator[str]:
    limit = largest_tolerance(scene)
    if scene.solver.force_tolerance > limit:
        found = f"{scene.solver.force_tolerance:g} N"
        yield (
            f"solver.force_tolerance: with {found} the force of a loose knot is not known to {PROMISED:.0%}; "
            f"at most {limit:.2g} N would promise that"
        )
    if scene.solver.threads > (os.cpu_count() or 1):
        yield f"solver.threads: {scene.solver.threads} are more than the {os.cpu_count()} processors of this machine"


def largest_tolerance(scene: Scene) -> float:
    """The largest `solver.force_tolerance` that promises the force of a loose knot to `PROMISED` [N]."""
    return PROMISED * LOOSE_FORCE * scene.force_scale / ForceTolerance.of(1.0).resultant


def _outside(key: str, value: float, usual: tuple[float, float], unit: str, why: str) -> Iterator[str]:
    if not usual[0] <= value <= usual[1]:
        yield f"{key}: {value:g} {unit} is unusual; {why}"
